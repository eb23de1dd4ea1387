// One process at a time writes into a run's folder.
//
// The lock is the kernel's (flock) on the file run.lock, which stays. It ends with its process,
// however that ends, so that a lock cannot be stale. The file says who holds the lock, or held it
// last.
#pragma once

#include <filesystem>

namespace impedraw {

inline constexpr const char* kLockFile = "run.lock";

class FolderLock {
 public:
  // Throws InputError naming the process that holds the lock.
  explicit FolderLock(const std::filesystem::path& folder);
  ~FolderLock();
  FolderLock(const FolderLock&) = delete;
  FolderLock& operator=(const FolderLock&) = delete;

  // Throws as the constructor, but takes no lock and makes no file.
  static void require_free(const std::filesystem::path& folder);

 private:
  int file_;
};

}  // namespace impedraw
