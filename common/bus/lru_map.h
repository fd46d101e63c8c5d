#pragma once

#include <cstddef>
#include <list>
#include <unordered_map>
#include <utility>

namespace cairn {

/// A map that holds the `capacity` keys used last. Not thread-safe.
template <typename Key, typename Value, typename Hash = std::hash<Key>>
class LruMap {
 public:
  explicit LruMap(size_t capacity) : capacity_(capacity) {}

  /// The key's value, which becomes the one used last; nullptr when it is not here. Holds until the next Insert.
  Value* Find(const Key& key) {
    const auto known = index_.find(key);
    if (known == index_.end()) return nullptr;
    entries_.splice(entries_.begin(), entries_, known->second);
    return &known->second->second;
  }

  /// Adds a key that is not here; the one used longest ago goes when there is no room.
  Value* Insert(const Key& key, Value value) {
    if (index_.size() >= capacity_) {
      index_.erase(entries_.back().first);
      entries_.pop_back();
    }
    entries_.emplace_front(key, std::move(value));
    index_[key] = entries_.begin();
    return &entries_.front().second;
  }

  size_t size() const { return index_.size(); }

 private:
  size_t capacity_;
  std::list<std::pair<Key, Value>> entries_;  // the one used last in front
  std::unordered_map<Key, typename std::list<std::pair<Key, Value>>::iterator, Hash> index_;
};

}  // namespace cairn
