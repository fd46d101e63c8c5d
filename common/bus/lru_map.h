#pragma once

#include <cstddef>
#include <list>
#include <unordered_map>
#include <utility>

namespace cairn {

/// A map that holds the keys used last, as many as weigh `capacity` together. Not thread-safe.
template <typename Key, typename Value, typename Hash = std::hash<Key>>
class LruMap {
 public:
  explicit LruMap(size_t capacity) : capacity_(capacity) {}

  /// The key's value, which becomes the one used last; nullptr when it is not here. Holds until the next Insert.
  Value* Find(const Key& key) {
    const auto known = index_.find(key);
    if (known == index_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, known->second);
    return &known->second->value;
  }

  /// Adds a key that is not here; those used longest ago go where there is no room. The newest stays, whatever it
  /// weighs.
  Value* Insert(const Key& key, Value value, size_t weight = 1) {
    while (!entries_.empty() && total_weight_ + weight > capacity_) {
      total_weight_ -= entries_.back().weight;
      index_.erase(entries_.back().key);
      entries_.pop_back();
    }
    entries_.push_front({key, std::move(value), weight});
    index_[key] = entries_.begin();
    total_weight_ += weight;
    return &entries_.front().value;
  }

  size_t size() const { return index_.size(); }
  size_t total_weight() const { return total_weight_; }

 private:
  struct Entry {
    Key key;
    Value value;
    size_t weight;
  };
  size_t capacity_;
  size_t total_weight_ = 0;
  std::list<Entry> entries_;  // the one used last in front
  std::unordered_map<Key, typename std::list<Entry>::iterator, Hash> index_;
};

}  // namespace cairn
