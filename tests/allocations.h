// Counts what goes to the heap: malloc itself is hooked, so that any way there counts, new, Eigen's
// aligned blocks or a library's. To be included by one file of a test program.
#pragma once

#include <atomic>
#include <cstdlib>

extern "C" void* __libc_malloc(std::size_t);
extern "C" void* __libc_calloc(std::size_t, std::size_t);
extern "C" void* __libc_realloc(void*, std::size_t);
extern "C" void* __libc_memalign(std::size_t, std::size_t);

namespace {
std::atomic<bool> counting{false};
std::atomic<int> allocations{0};
thread_local bool counting_here = false;
thread_local int allocations_here = 0;
void count() {
  if (counting.load(std::memory_order_relaxed)) allocations.fetch_add(1, std::memory_order_relaxed);
  if (counting_here) ++allocations_here;
}

template <typename F>
int allocations_in(F&& f) {
  allocations = 0;
  counting = true;
  f();
  counting = false;
  return allocations;
}

// Of the calling thread alone.
template <typename F>
[[maybe_unused]] int allocations_of_this_thread_in(F&& f) {
  allocations_here = 0;
  counting_here = true;
  f();
  counting_here = false;
  return allocations_here;
}
}  // namespace

// AddressSanitizer has an allocator of its own: there nothing is counted.
#if defined(__has_feature)
#if __has_feature(address_sanitizer)
#define IMPEDRAW_OWN_ALLOCATOR
#endif
#endif
#ifndef IMPEDRAW_OWN_ALLOCATOR
extern "C" {
void* malloc(std::size_t size) {
  count();
  return __libc_malloc(size);
}
void* calloc(std::size_t n, std::size_t size) {
  count();
  return __libc_calloc(n, size);
}
void* realloc(void* p, std::size_t size) {
  count();
  return __libc_realloc(p, size);
}
void* memalign(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
void* aligned_alloc(std::size_t alignment, std::size_t size) {
  count();
  return __libc_memalign(alignment, size);
}
int posix_memalign(void** out, std::size_t alignment,
                   std::size_t size) noexcept {  // as mm_malloc.h declares it
  count();
  *out = __libc_memalign(alignment, size);
  return *out ? 0 : 12;
}
}
#endif
