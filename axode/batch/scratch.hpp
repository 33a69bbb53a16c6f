#pragma once
#include <cstddef>
#include <memory>
#include <new>

namespace axode::batch {

/// Uninitialised memory for n entries of type T, which begins at a cache line; null if n = 0.
template <class T> std::shared_ptr<T> scratch(std::size_t n) {
  if (n == 0) return nullptr;
  return {static_cast<T*>(::operator new (n * sizeof(T), std::align_val_t{64})),
          [](T* p) { ::operator delete (p, std::align_val_t{64}); }};
}

}  // namespace axode::batch
