#include "learner/credit_ledger.h"

#include <gtest/gtest.h>

namespace cairn::learner {
namespace {

constexpr Duration kPatience = std::chrono::milliseconds(50);

class CreditLedgerTest : public ::testing::Test {
 protected:
  CreditLedgerTest() {
    for (int id = 0; id < 2; ++id) {
      Hello hello;
      hello.session = 10 + id;
      hello.actor_id = id;
      fleet_.Join(hello, now_);
    }
  }
  ActorRecord& actor(int id) { return fleet_.actors().at(id); }

  Fleet fleet_{2, 2, 0, 0, ""};
  CreditLedger ledger_{1000, 100, 0};
  TimePoint now_{std::chrono::hours(1)};
};

TEST_F(CreditLedgerTest, OneThatHangsDoesNotGatherItAll) {
  for (int round = 1; round <= 50; ++round) {
    ledger_.Allow(100 + actor(1).accepted);  // what one of them makes comes free again
    ledger_.Distribute(&fleet_, Duration::zero(), now_);
    actor(1).accepted = actor(1).credit;
  }
  EXPECT_EQ(actor(0).credit, 51) << "half of the first hundred, with what rounding leaves";
  EXPECT_GT(actor(1).accepted, 900);
}

TEST_F(CreditLedgerTest, NeverPassesWhatIsAllowedAndEndsAtTheTotal) {
  for (int64_t allowed = 1; allowed < 3000; allowed += 37) {
    ledger_.Allow(allowed);
    ledger_.Distribute(&fleet_, Duration::zero(), now_);
    EXPECT_EQ(actor(0).credit + actor(1).credit, std::min<int64_t>(allowed, 1000));
  }
}

TEST_F(CreditLedgerTest, SmallAmountsGatherButNotForLong) {
  ledger_.Allow(100);
  ASSERT_TRUE(ledger_.Distribute(&fleet_, kPatience, now_));
  ledger_.Allow(199);
  EXPECT_FALSE(ledger_.Distribute(&fleet_, kPatience, now_));
  EXPECT_TRUE(ledger_.Distribute(&fleet_, kPatience, now_ + kPatience));
  ledger_.Allow(1000);
  actor(0).accepted = actor(1).accepted = 480;
  EXPECT_TRUE(ledger_.Distribute(&fleet_, kPatience, now_)) << "the last steps of a run do not wait";
}

TEST_F(CreditLedgerTest, ActorsThatWaitForCreditGetBurstsInTurn) {
  CreditLedger ledger(1000, 1, 60);
  ledger.Allow(60);
  ledger.Distribute(&fleet_, kPatience, now_);
  EXPECT_EQ(actor(0).credit, 60);
  EXPECT_EQ(actor(1).credit, 0);
  actor(0).accepted = 60;
  ledger.Allow(120);
  ledger.Distribute(&fleet_, kPatience, now_);
  EXPECT_EQ(actor(0).credit, 60);
  EXPECT_EQ(actor(1).credit, 60);
  ledger.Allow(140);
  ledger.Distribute(&fleet_, kPatience, now_);
  EXPECT_EQ(actor(0).credit, 80) << "the other one has not used up what it got: whoever has least is filled up";
}

TEST_F(CreditLedgerTest, WhatAGoneSessionHadNotUsedIsFree) {
  ledger_.Allow(200);
  ledger_.Distribute(&fleet_, Duration::zero(), now_);
  actor(0).accepted = 30;
  ledger_.Retire(30);
  fleet_.Forget(0);
  ledger_.Distribute(&fleet_, Duration::zero(), now_);
  EXPECT_EQ(actor(1).credit, 170);
}

}  // namespace
}  // namespace cairn::learner
