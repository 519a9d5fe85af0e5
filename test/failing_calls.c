/* Preloaded: the n-th call of a kind on a file whose path has some text in it fails, and so do those after it if asked. */
#define _GNU_SOURCE
#include <dlfcn.h>
#include <errno.h>
#include <fcntl.h>
#include <stdarg.h>
#include <stdio.h>
#include <string.h>
#include <unistd.h>

enum { WRITE, FSYNC, READ, CLOSE, RENAME, OPEN };

static int kind = -1, at, number, all_after, count;
static char text[256];

void fail(int which, int nth, int error, int sticky, const char *part)
{
    kind = which, at = nth, number = error, all_after = sticky, count = 0;
    strncpy(text, part, sizeof text - 1);
}

int calls(void) { return count; }

static int fails(int which, const char *path)
{
    if (which != kind || !path || !strstr(path, text)) return 0;
    count++;
    if (count != at && !(all_after && at && count > at)) return 0;
    errno = number;
    return 1;
}

static int fails_on(int which, int fd)
{
    char link[64], path[4096];
    if (which != kind) return 0;
    snprintf(link, sizeof link, "/proc/self/fd/%d", fd);
    ssize_t length = readlink(link, path, sizeof path - 1);
    if (length < 0) return 0;
    path[length] = 0;
    return fails(which, path);
}

#define REAL(name) static __typeof__(name) *real; if (!real) real = (__typeof__(name) *)dlsym(RTLD_NEXT, #name)

ssize_t write(int fd, const void *data, size_t size)
{
    REAL(write);
    return fails_on(WRITE, fd) ? -1 : real(fd, data, size);
}

int fsync(int fd)
{
    REAL(fsync);
    return fails_on(FSYNC, fd) ? -1 : real(fd);
}

ssize_t read(int fd, void *data, size_t size)
{
    REAL(read);
    return fails_on(READ, fd) ? -1 : real(fd, data, size);
}

int close(int fd)
{
    REAL(close);
    int failed = fails_on(CLOSE, fd), error = errno, done = real(fd);
    if (failed) errno = error;
    return failed ? -1 : done;
}

int rename(const char *from, const char *to)
{
    REAL(rename);
    return fails(RENAME, to) ? -1 : real(from, to);
}

int open64(const char *path, int flags, ...)
{
    REAL(open64);
    mode_t mode = 0;
    if (flags & (O_CREAT | O_TMPFILE)) {
        va_list rest;
        va_start(rest, flags);
        mode = va_arg(rest, mode_t);
        va_end(rest);
    }
    return fails(OPEN, path) ? -1 : real(path, flags, mode);
}
