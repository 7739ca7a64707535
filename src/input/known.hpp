#pragma once

#include <cstddef>
#include <map>
#include <mutex>

namespace viscobar {

/// The values of up to a hundred keys that were asked for before, by all threads.
template <class Key, class Value>
class Known {
 public:
  template <class Make>
  Value operator()(const Key& key, Make&& make) {
    {
      const std::lock_guard lock(mutex_);
      if (const auto known = values_.find(key); known != values_.end()) return known->second;
    }
    const Value made = make();
    constexpr std::size_t most = 100;
    const std::lock_guard lock(mutex_);
    if (values_.size() >= most) values_.clear();
    return values_.emplace(key, made).first->second;
  }

 private:
  std::mutex mutex_;
  std::map<Key, Value> values_;
};

}  // namespace viscobar
