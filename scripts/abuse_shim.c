/* LD_PRELOAD for scripts/abuse: counts what a program does to files below ABUSE_DIR, writes it down, makes one operation
 * fail, or kills the program there.
 *
 *   ABUSE_DIR=/abs/dir      only files below it count
 *   ABUSE_LOG=file          each operation, so that a disk can be rebuilt from it:
 *                           kind path offset length, NUL, then the bytes
 *   ABUSE_AT=n              operation number n, from 1 on, is
 *   ABUSE_DO=errno | kill | tear   refused with that errno; the program killed before it; a write done by half, then killed
 *   ABUSE_STICKY=1          all after it are refused too: a disk that stays full
 */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <limits.h>
#include <pthread.h>
#include <signal.h>
#include <stdarg.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/stat.h>
#include <unistd.h>

#define FILES 4096
static char *path_of[FILES];
static off_t at_of[FILES];
static long count, at = -1;
static int refuse, sticky, killing, tearing, log_fd = -1;
static char base[PATH_MAX];
static pthread_mutex_t lock = PTHREAD_MUTEX_INITIALIZER;

#define REAL(type, name, ...)                  \
  static type (*real)(__VA_ARGS__);            \
  if (!real) real = dlsym(RTLD_NEXT, #name);

static ssize_t raw_write(int fd, const void *data, size_t n) {
  REAL(ssize_t, write, int, const void *, size_t)
  return real(fd, data, n);
}
static int raw_open(const char *path, int flags, mode_t mode) {
  REAL(int, open, const char *, int, mode_t)
  return real(path, flags, mode);
}

__attribute__((constructor)) static void begin(void) {
  const char *dir = getenv("ABUSE_DIR"), *log = getenv("ABUSE_LOG"), *n = getenv("ABUSE_AT"), *what = getenv("ABUSE_DO");
  if (dir) snprintf(base, sizeof base, "%s", dir);
  if (log) log_fd = raw_open(log, O_WRONLY | O_CREAT | O_APPEND | O_CLOEXEC, 0644);
  if (n) at = atol(n);
  if (what) {
    killing = !strcmp(what, "kill") || !strcmp(what, "tear");
    tearing = !strcmp(what, "tear");
    refuse = atoi(what);
  }
  sticky = getenv("ABUSE_STICKY") != NULL;
}

/* The path if it counts, absolute; else NULL. */
static const char *counted(const char *path, char *out) {
  if (!base[0] || !path) return NULL;
  if (path[0] == '/') {
    snprintf(out, PATH_MAX, "%s", path);
  } else {
    char here[PATH_MAX];
    if (!getcwd(here, sizeof here)) return NULL;
    snprintf(out, PATH_MAX, "%.2000s/%.2000s", here, path);
  }
  return strncmp(out, base, strlen(base)) == 0 && (out[strlen(base)] == '/' || !out[strlen(base)]) ? out : NULL;
}

/* Writes the operation down and returns an errno to refuse it with, or 0. `half` is set where a write is to be torn. */
static int operation(const char *kind, const char *path, const char *more, off_t offset, const void *data, size_t size,
                     int *half) {
  pthread_mutex_lock(&lock);
  const long mine = ++count;
  int fault = 0;
  if (mine == at && killing && !(tearing && half && size > 1)) kill(getpid(), SIGKILL);
  if (mine == at && tearing) *half = 1;
  if (refuse && (mine == at || (sticky && at > 0 && mine > at))) fault = refuse;
  if (log_fd >= 0 && !fault) {
    char head[2 * PATH_MAX + 64];
    const int n = snprintf(head, sizeof head, "%s\t%s\t%s\t%lld\t%zu\n", kind, path, more, (long long)offset, size);
    raw_write(log_fd, head, (size_t)n);
    if (data) raw_write(log_fd, data, size);
  }
  pthread_mutex_unlock(&lock);
  return fault;
}

static int opened(const char *path, int flags, mode_t mode) {
  char full[PATH_MAX];
  const char *p = (flags & O_ACCMODE) != O_RDONLY ? counted(path, full) : NULL;
  if (p && (flags & (O_CREAT | O_TRUNC))) {
    const int fault = operation(flags & O_TRUNC ? "truncate" : "create", p, "-", 0, NULL, 0, NULL);
    if (fault) return errno = fault, -1;
  }
  const int fd = raw_open(path, flags, mode);
  char folder[PATH_MAX];
  const char *d = p ? p : counted(path, folder);
  if (fd >= 0 && fd < FILES && d) {
    free(path_of[fd]);
    path_of[fd] = strdup(d);
    at_of[fd] = 0;
  }
  return fd;
}
int open(const char *path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
  va_end(more);
  return opened(path, flags, mode);
}
int open64(const char *path, int flags, ...) {
  va_list more;
  va_start(more, flags);
  const mode_t mode = flags & O_CREAT ? va_arg(more, mode_t) : 0;
  va_end(more);
  return opened(path, flags, mode);
}

static const char *file(int fd) { return fd >= 0 && fd < FILES ? path_of[fd] : NULL; }

ssize_t write(int fd, const void *data, size_t n) {
  if (!file(fd)) return raw_write(fd, data, n);
  int half = 0;
  const off_t offset = lseek(fd, 0, SEEK_CUR);
  const int fault = operation("write", file(fd), "-", offset, data, n, &half);
  if (fault) return errno = fault, -1;
  if (half) raw_write(fd, data, n / 2), kill(getpid(), SIGKILL);
  return raw_write(fd, data, n);
}
static ssize_t at_offset(int fd, const void *data, size_t n, off_t offset) {
  REAL(ssize_t, pwrite64, int, const void *, size_t, off_t)
  if (!file(fd)) return real(fd, data, n, offset);
  int half = 0;
  const int fault = operation("write", file(fd), "-", offset, data, n, &half);
  if (fault) return errno = fault, -1;
  if (half) real(fd, data, n / 2, offset), kill(getpid(), SIGKILL);
  return real(fd, data, n, offset);
}
ssize_t pwrite(int fd, const void *data, size_t n, off_t offset) { return at_offset(fd, data, n, offset); }
ssize_t pwrite64(int fd, const void *data, size_t n, off_t offset) { return at_offset(fd, data, n, offset); }

static int cut(int fd, off_t length) {
  REAL(int, ftruncate64, int, off_t)
  if (file(fd)) {
    const int fault = operation("cut", file(fd), "-", length, NULL, 0, NULL);
    if (fault) return errno = fault, -1;
  }
  return real(fd, length);
}
int ftruncate(int fd, off_t length) { return cut(fd, length); }
int ftruncate64(int fd, off_t length) { return cut(fd, length); }

/* Waiting for the disk is what takes the time of a trial: only that it was asked for counts here. */
static int synced(int fd) {
  if (file(fd)) {
    const int fault = operation("sync", file(fd), "-", 0, NULL, 0, NULL);
    if (fault) return errno = fault, -1;
  }
  return 0;
}
int fsync(int fd) { return synced(fd); }
int fdatasync(int fd) { return synced(fd); }

int close(int fd) {
  REAL(int, close, int)
  if (file(fd)) free(path_of[fd]), path_of[fd] = NULL;
  return real(fd);
}
int rename(const char *from, const char *to) {
  REAL(int, rename, const char *, const char *)
  char a[PATH_MAX], b[PATH_MAX];
  if (counted(from, a) && counted(to, b)) {
    const int fault = operation("rename", a, b, 0, NULL, 0, NULL);
    if (fault) return errno = fault, -1;
  }
  return real(from, to);
}
static void gone(const char *path) {
  char full[PATH_MAX];
  if (counted(path, full)) operation("remove", full, "-", 0, NULL, 0, NULL);
}
int unlink(const char *path) {
  REAL(int, unlink, const char *)
  gone(path);
  return real(path);
}
int unlinkat(int folder, const char *path, int flags) {
  REAL(int, unlinkat, int, const char *, int)
  char full[PATH_MAX];
  if (folder == AT_FDCWD)
    gone(path);
  else if (file(folder)) {
    snprintf(full, sizeof full, "%.2000s/%.2000s", file(folder), path);
    gone(full);
  }
  return real(folder, path, flags);
}
int remove(const char *path) {
  REAL(int, remove, const char *)
  gone(path);
  return real(path);
}
int mkdir(const char *path, mode_t mode) {
  REAL(int, mkdir, const char *, mode_t)
  char full[PATH_MAX];
  if (counted(path, full)) {
    const int fault = operation("mkdir", full, "-", 0, NULL, 0, NULL);
    if (fault) return errno = fault, -1;
  }
  return real(path, mode);
}
