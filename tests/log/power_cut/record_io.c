/* Preloaded into a process, records what the process does to the files of one folder, in order: the
 * input of replay.py, which shows what a power cut would leave.
 *
 *   RECORD_IO_FOLDER  the folder, absolute; everything beneath it is recorded
 *   RECORD_IO_TRACE   the file that the record goes to
 *
 * A record is: operation (1 byte), file number, offset, length, length of the name (8 bytes each,
 * little-endian), name, data. The numbers that an operation does not use are 0. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <pthread.h>
#include <stdarg.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <sys/syscall.h>
#include <sys/uio.h>
#include <unistd.h>

enum { kFiles = 4096 };
static uint64_t number_of[kFiles]; /* of an open descriptor: its inode; 0: not ours */
static char is_folder[kFiles];
static char folder[4096];
static int trace = -1;
static pthread_mutex_t lock = PTHREAD_RECURSIVE_MUTEX_INITIALIZER_NP;

#define REAL(result, name, ...)       \
  static result (*real)(__VA_ARGS__); \
  if (!real) real = dlsym(RTLD_NEXT, name)

static void put(const void* data, size_t bytes) {
  const char* at = data;
  while (bytes > 0) {
    const ssize_t n = syscall(SYS_write, trace, at, bytes);
    if (n <= 0) abort();
    at += n;
    bytes -= (size_t)n;
  }
}

static void record(char operation, uint64_t file, uint64_t offset, const char* name,
                   const void* data, uint64_t length) {
  const uint64_t head[4] = {file, offset, length, name ? strlen(name) : 0};
  put(&operation, 1);
  put(head, sizeof head);
  if (name) put(name, head[3]);
  if (data) put(data, length);
}

static void __attribute__((constructor)) start(void) {
  const char* from = getenv("RECORD_IO_FOLDER");
  const char* to = getenv("RECORD_IO_TRACE");
  if (!from || !to) return;
  snprintf(folder, sizeof folder, "%s/", from);
  trace = (int)syscall(SYS_openat, AT_FDCWD, to, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0600);
}

/* The absolute name, if it is in the folder (or the folder itself); else 0. */
static const char* ours(const char* path, char* buffer) {
  if (trace < 0 || !path) return 0;
  if (path[0] == '/') {
    snprintf(buffer, 8192, "%s", path);
  } else {
    char cwd[4096];
    if (!getcwd(cwd, sizeof cwd)) return 0;
    snprintf(buffer, 8192, "%s/%s", cwd, path[0] == '.' && path[1] == '/' ? path + 2 : path);
  }
  size_t n = strlen(buffer);
  while (n > 1 && (buffer[n - 1] == '/' || (buffer[n - 1] == '.' && buffer[n - 2] == '/')))
    buffer[--n] = 0;
  if (strncmp(buffer, folder, strlen(folder)) == 0) return buffer + strlen(folder);
  if (strlen(buffer) + 1 == strlen(folder) && strncmp(buffer, folder, n) == 0) return "";
  return 0;
}

static void opened(int fd, const char* path, int flags) {
  char buffer[8192];
  struct stat s;
  if (fd < 0 || fd >= kFiles) return;
  number_of[fd] = 0;
  const char* name = ours(path, buffer);
  if (!name || fstat(fd, &s) != 0) return;
  number_of[fd] = s.st_ino;
  is_folder[fd] = S_ISDIR(s.st_mode);
  /* A new file, or one of which only the name was known. */
  if (!is_folder[fd] && (flags & O_CREAT)) record('c', s.st_ino, 0, name, 0, 0);
  if (!is_folder[fd] && (flags & O_TRUNC)) record('t', s.st_ino, 0, 0, 0, 0);
}

static int open_and_record(int folder_fd, const char* path, int flags, mode_t mode) {
  pthread_mutex_lock(&lock);
  const int fd = (int)syscall(SYS_openat, folder_fd, path, flags, mode);
  const int error = errno;
  opened(fd, path, flags);
  errno = error;
  pthread_mutex_unlock(&lock);
  return fd;
}

#define MODE                           \
  mode_t mode = 0;                     \
  if (flags & (O_CREAT | O_TMPFILE)) { \
    va_list rest;                      \
    va_start(rest, flags);             \
    mode = va_arg(rest, mode_t);       \
    va_end(rest);                      \
  }

int open(const char* path, int flags, ...) {
  MODE return open_and_record(AT_FDCWD, path, flags, mode);
}
int open64(const char* path, int flags, ...) {
  MODE return open_and_record(AT_FDCWD, path, flags, mode);
}
int openat(int at, const char* path, int flags, ...) {
  MODE return open_and_record(at, path, flags, mode);
}
int openat64(int at, const char* path, int flags, ...) {
  MODE return open_and_record(at, path, flags, mode);
}

static FILE* fopen_and_record(FILE* (*real)(const char*, const char*), const char* path,
                              const char* mode) {
  pthread_mutex_lock(&lock);
  FILE* file = real(path, mode);
  if (file)
    opened(fileno(file), path,
           mode[0] == 'w'   ? O_CREAT | O_TRUNC
           : mode[0] == 'a' ? O_CREAT
                            : O_RDONLY);
  pthread_mutex_unlock(&lock);
  return file;
}
FILE* fopen(const char* path, const char* mode) {
  REAL(FILE*, "fopen", const char*, const char*);
  return fopen_and_record(real, path, mode);
}
FILE* fopen64(const char* path, const char* mode) {
  REAL(FILE*, "fopen64", const char*, const char*);
  return fopen_and_record(real, path, mode);
}

static int known(int fd) { return trace >= 0 && fd >= 0 && fd < kFiles && number_of[fd]; }

int close(int fd) {
  pthread_mutex_lock(&lock);
  if (fd >= 0 && fd < kFiles) number_of[fd] = 0;
  const int result = (int)syscall(SYS_close, fd);
  pthread_mutex_unlock(&lock);
  return result;
}

static ssize_t write_and_record(int fd, const void* data, size_t bytes, int64_t offset) {
  if (!known(fd))
    return offset < 0 ? syscall(SYS_write, fd, data, bytes)
                      : syscall(SYS_pwrite64, fd, data, bytes, offset);
  pthread_mutex_lock(&lock);
  ssize_t n;
  int64_t at = offset;
  if (offset < 0) {
    n = syscall(SYS_write, fd, data, bytes);
    at = lseek(fd, 0, SEEK_CUR) - n;
  } else {
    n = syscall(SYS_pwrite64, fd, data, bytes, offset);
  }
  const int error = errno;
  if (n > 0) record('w', number_of[fd], (uint64_t)at, 0, data, (uint64_t)n);
  errno = error;
  pthread_mutex_unlock(&lock);
  return n;
}
ssize_t write(int fd, const void* data, size_t bytes) {
  return write_and_record(fd, data, bytes, -1);
}
ssize_t pwrite(int fd, const void* data, size_t bytes, off_t at) {
  return write_and_record(fd, data, bytes, at);
}
ssize_t pwrite64(int fd, const void* data, size_t bytes, off64_t at) {
  return write_and_record(fd, data, bytes, at);
}
ssize_t writev(int fd, const struct iovec* pieces, int count) {
  if (!known(fd)) return syscall(SYS_writev, fd, pieces, count);
  ssize_t sum = 0;
  for (int i = 0; i < count; ++i) {
    if (pieces[i].iov_len == 0) continue;
    const ssize_t n = write_and_record(fd, pieces[i].iov_base, pieces[i].iov_len, -1);
    if (n < 0) return sum > 0 ? sum : n;
    sum += n;
    if ((size_t)n < pieces[i].iov_len) break;
  }
  return sum;
}

/* Copies within the kernel would not be seen; the callers have another way. */
ssize_t sendfile(int out, int in, off_t* at, size_t n) {
  (void)out, (void)in, (void)at, (void)n;
  errno = ENOSYS;
  return -1;
}
ssize_t sendfile64(int out, int in, off64_t* at, size_t n) {
  (void)out, (void)in, (void)at, (void)n;
  errno = ENOSYS;
  return -1;
}
ssize_t copy_file_range(int in, off64_t* a, int out, off64_t* b, size_t n, unsigned f) {
  (void)in, (void)a, (void)out, (void)b, (void)n, (void)f;
  errno = ENOSYS;
  return -1;
}

static int truncate_and_record(int fd, int64_t size) {
  pthread_mutex_lock(&lock);
  const int result = (int)syscall(SYS_ftruncate, fd, size);
  if (result == 0 && known(fd)) record('t', number_of[fd], (uint64_t)size, 0, 0, 0);
  pthread_mutex_unlock(&lock);
  return result;
}
int ftruncate(int fd, off_t size) { return truncate_and_record(fd, size); }
int ftruncate64(int fd, off64_t size) { return truncate_and_record(fd, size); }

/* Recorded when it has returned: until then, nothing is promised. */
static int sync_and_record(int fd, long call) {
  uint64_t upto = 0;
  pthread_mutex_lock(&lock);
  if (known(fd)) record('b', number_of[fd], 0, 0, 0, 0); /* what follows is not covered */
  pthread_mutex_unlock(&lock);
  (void)upto;
  const int result = (int)syscall(call, fd);
  pthread_mutex_lock(&lock);
  if (result == 0 && known(fd)) record(is_folder[fd] ? 'd' : 's', number_of[fd], 0, 0, 0, 0);
  pthread_mutex_unlock(&lock);
  return result;
}
int fsync(int fd) { return sync_and_record(fd, SYS_fsync); }
int fdatasync(int fd) { return sync_and_record(fd, SYS_fdatasync); }

static int rename_and_record(int from_fd, const char* from, int to_fd, const char* to) {
  char a[8192], b[8192];
  pthread_mutex_lock(&lock);
  const int result = (int)syscall(SYS_renameat, from_fd, from, to_fd, to);
  const int error = errno;
  const char *x = ours(from, a), *y = ours(to, b);
  if (result == 0 && x && y) record('r', 0, 0, x, y, strlen(y));
  errno = error;
  pthread_mutex_unlock(&lock);
  return result;
}
int rename(const char* from, const char* to) {
  return rename_and_record(AT_FDCWD, from, AT_FDCWD, to);
}
int renameat(int a, const char* from, int b, const char* to) {
  return rename_and_record(a, from, b, to);
}

static int remove_and_record(int at, const char* path, int flags) {
  char buffer[8192];
  pthread_mutex_lock(&lock);
  const int result = (int)syscall(SYS_unlinkat, at, path, flags);
  const int error = errno;
  const char* name = ours(path, buffer);
  if (result == 0 && name) record('u', 0, 0, name, 0, 0);
  errno = error;
  pthread_mutex_unlock(&lock);
  return result;
}
int unlink(const char* path) { return remove_and_record(AT_FDCWD, path, 0); }
int unlinkat(int at, const char* path, int flags) { return remove_and_record(at, path, flags); }
int remove(const char* path) {
  const int result = remove_and_record(AT_FDCWD, path, 0);
  return result != 0 && errno == EISDIR ? remove_and_record(AT_FDCWD, path, AT_REMOVEDIR) : result;
}

int mkdir(const char* path, mode_t mode) {
  char buffer[8192];
  pthread_mutex_lock(&lock);
  const int result = (int)syscall(SYS_mkdirat, AT_FDCWD, path, mode);
  const int error = errno;
  const char* name = ours(path, buffer);
  if (result == 0 && name) record('m', 0, 0, name, 0, 0);
  errno = error;
  pthread_mutex_unlock(&lock);
  return result;
}

/* For the program that is recorded: how far it has come. */
void record_io_mark(uint64_t a, uint64_t b) {
  pthread_mutex_lock(&lock);
  if (trace >= 0) record('n', a, b, 0, 0, 0);
  pthread_mutex_unlock(&lock);
}
