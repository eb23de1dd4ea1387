// Files that are whole or absent, whatever the instant of a kill or a power cut.
//
// A file is written under a temporary name in its own folder, synced to the disk, renamed to its
// name, and the folder is synced. Symbolic links are never followed: a rename replaces the link,
// not the file that it points to. A process that is killed may leave a temporary file, which
// remove_unfinished() removes later.
#pragma once

#include <filesystem>
#include <string_view>

namespace impedraw {

// The temporary name of `file`, which contains the process's id.
std::filesystem::path unfinished(const std::filesystem::path& file);

// Replaces `file`. Throws std::runtime_error "cannot write <file>: <cause>"; `file` is then as it
// was.
void write_whole(const std::filesystem::path& file, std::string_view content);

// Gives `from`, a complete file in the folder of `to`, the name `to`. Throws as write_whole().
void put_in_place(const std::filesystem::path& from, const std::filesystem::path& to);

// Writes all of it to an open file. Returns 0, or errno.
int write_all(int file, std::string_view content) noexcept;

// Syncs a folder's entries to the disk: names made, changed and removed. Best effort, because not
// every file system can.
void sync_folder(const std::filesystem::path& folder) noexcept;

bool is_unfinished(const std::filesystem::path& file);  // by its name

// Removes the temporary files of processes that have ended from a folder.
void remove_unfinished(const std::filesystem::path& folder) noexcept;

// True for a regular file that `path` itself names, without following a symbolic link.
bool is_own_file(const std::filesystem::path& path) noexcept;

}  // namespace impedraw
