/* Runs a program and makes one of its system calls on files fail, or kills it at that call.
 *
 *   inject LOG NEEDLE NUMBER FAULT PROGRAM ARGUMENT...
 *
 * Calls on a path that contains NEEDLE, or on a descriptor of such a path, are numbered from 1 over
 * all threads. FAULT is injected at call NUMBER:
 *
 *   none        no fault; NUMBER may be 0
 *   kill        SIGKILL, and the call is not made
 *   torn        a write writes half of its bytes, any other call is made; then SIGKILL
 *   short       a read or write moves half of its bytes
 *   errno=N     the call is not made and fails with N
 *   full=N      as errno=N, also for all later calls that create, extend or sync a file
 *
 * Writes a line to LOG for each numbered call: name, path, second path, requested bytes and result,
 * separated by tabs. The exit code is the program's; 137 if it was killed, 125 if this
 * machine does not permit tracing.
 *
 * Uses ptrace, because some libraries make system calls without libc.
 */
#define _GNU_SOURCE
#include <elf.h>
#include <errno.h>
#include <fcntl.h>
#include <signal.h>
#include <stdint.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <sys/ptrace.h>
#include <sys/syscall.h>
#include <sys/types.h>
#include <sys/uio.h>
#include <sys/user.h>
#include <sys/wait.h>
#include <unistd.h>

enum { UNTRACEABLE = 125, KILLED = 137, MAX_PATH = 4096, MAX_THREADS = 256 };

/* How a call names its file: by a descriptor (F), a path (P), a folder and a path (A), or by two
 * paths (PP, AA). */
enum form { F, P, A, PP, AA };

struct call {
    long number;
    const char *name;
    enum form form;
    int moves;  /* whether it moves bytes; their number is the third argument */
    int grows;  /* whether it may need disk space */
};

static const struct call CALLS[] = {
#ifdef SYS_open
    {SYS_open, "open", P, 0, 0},
#endif
#ifdef SYS_stat
    {SYS_stat, "stat", P, 0, 0},
    {SYS_lstat, "lstat", P, 0, 0},
#endif
#ifdef SYS_readlink
    {SYS_readlink, "readlink", P, 0, 0},
#endif
#ifdef SYS_access
    {SYS_access, "access", P, 0, 0},
#endif
#ifdef SYS_mkdir
    {SYS_mkdir, "mkdir", P, 0, 1},
#endif
#ifdef SYS_rmdir
    {SYS_rmdir, "rmdir", P, 0, 0},
#endif
#ifdef SYS_unlink
    {SYS_unlink, "unlink", P, 0, 0},
#endif
#ifdef SYS_rename
    {SYS_rename, "rename", PP, 0, 1},
#endif
#ifdef SYS_link
    {SYS_link, "link", PP, 0, 1},
#endif
#ifdef SYS_newfstatat
    {SYS_newfstatat, "stat", A, 0, 0},
#endif
#ifdef SYS_renameat
    {SYS_renameat, "rename", AA, 0, 1},
#endif
    {SYS_openat, "open", A, 0, 0},
    {SYS_statx, "stat", A, 0, 0},
    {SYS_readlinkat, "readlink", A, 0, 0},
    {SYS_faccessat, "access", A, 0, 0},
    {SYS_mkdirat, "mkdir", A, 0, 1},
    {SYS_unlinkat, "unlink", A, 0, 0},
    {SYS_renameat2, "rename", AA, 0, 1},
    {SYS_linkat, "link", AA, 0, 1},
    {SYS_fstat, "stat", F, 0, 0},
    {SYS_read, "read", F, 1, 0},
    {SYS_pread64, "read", F, 1, 0},
    {SYS_write, "write", F, 1, 1},
    {SYS_pwrite64, "write", F, 1, 1},
    {SYS_writev, "writev", F, 0, 1},
    {SYS_fsync, "fsync", F, 0, 1},
    {SYS_fdatasync, "fsync", F, 0, 1},
    {SYS_ftruncate, "truncate", F, 0, 1},
    {SYS_fallocate, "allocate", F, 0, 1},
    {SYS_fchmod, "chmod", F, 0, 0},
    {SYS_flock, "lock", F, 0, 0},
    {SYS_getdents64, "list", F, 0, 0},
};

/* The descriptor of mmap is its fifth argument. */
static const struct call MAP = {SYS_mmap, "map", F, 0, 0};

/* A numbered call that a thread is making. */
struct pending {
    pid_t thread;
    const struct call *call;
    char path[MAX_PATH], second[MAX_PATH];
    uint64_t bytes;
    int result;  /* result to report instead of the call's own; 0 to keep that */
    int ends;    /* whether the program is killed after the call */
};

static struct pending PENDING[MAX_THREADS];

static struct pending *pending_of(pid_t thread) {
    struct pending *free_one = NULL;
    for (int i = 0; i < MAX_THREADS; i++) {
        if (PENDING[i].thread == thread) return &PENDING[i];
        if (PENDING[i].thread == 0 && !free_one) free_one = &PENDING[i];
    }
    return free_one;
}

#if defined(__x86_64__)
static int replace(pid_t thread, int skips, const uint64_t *third, const long *result) {
    struct user_regs_struct registers;
    if (ptrace(PTRACE_GETREGS, thread, 0, &registers)) return -1;
    if (skips) registers.orig_rax = (uint64_t)-1;
    if (third) registers.rdx = *third;
    if (result) registers.rax = (uint64_t)*result;
    return ptrace(PTRACE_SETREGS, thread, 0, &registers) ? -1 : 0;
}
#elif defined(__aarch64__)
static int replace(pid_t thread, int skips, const uint64_t *third, const long *result) {
    struct user_regs_struct registers;
    struct iovec all = {&registers, sizeof registers};
    if (ptrace(PTRACE_GETREGSET, thread, NT_PRSTATUS, &all)) return -1;
    if (third) registers.regs[2] = *third;
    if (result) registers.regs[0] = (uint64_t)*result;
    if (ptrace(PTRACE_SETREGSET, thread, NT_PRSTATUS, &all)) return -1;
    int none = -1;
    struct iovec number = {&none, sizeof none};
    return skips && ptrace(PTRACE_SETREGSET, thread, 0x404 /* NT_ARM_SYSTEM_CALL */, &number) ? -1 : 0;
}
#else
#error "the registers of this processor are not supported"
#endif

/* Reads a string of the program, one page at a time, because the next page may not be mapped. */
static void read_string(pid_t thread, uint64_t address, char *to, size_t size) {
    size_t length = 0;
    while (length + 1 < size) {
        size_t step = 4096 - (address + length) % 4096;
        if (step > size - 1 - length) step = size - 1 - length;
        struct iovec local = {to + length, step}, remote = {(void *)(uintptr_t)(address + length), step};
        ssize_t read = process_vm_readv(thread, &local, 1, &remote, 1, 0);
        if (read <= 0) break;
        if (memchr(to + length, 0, (size_t)read)) return;
        length += (size_t)read;
    }
    to[length] = 0;
}

/* Reads the path of a descriptor's file, or of the current folder, from a link in /proc. */
static void read_link(pid_t thread, int descriptor, char *to, size_t size) {
    char link[64];
    if (descriptor == AT_FDCWD) snprintf(link, sizeof link, "/proc/%d/cwd", (int)thread);
    else snprintf(link, sizeof link, "/proc/%d/fd/%d", (int)thread, descriptor);
    ssize_t length = readlink(link, to, size - 1);
    to[length > 0 ? length : 0] = 0;
}

static void read_path(pid_t thread, int folder, uint64_t address, char *to) {
    char path[MAX_PATH];
    read_string(thread, address, path, sizeof path);
    if (path[0] == '/') {
        memcpy(to, path, MAX_PATH);
        return;
    }
    read_link(thread, folder, to, MAX_PATH);
    size_t length = strlen(to);
    if (path[0]) snprintf(to + length, MAX_PATH - length, "/%s", path);
}

/* The call that a thread is about to make, with its paths; NULL if it is not in CALLS. */
static const struct call *find(pid_t thread, const struct __ptrace_syscall_info *info, struct pending *into) {
    const __typeof__(info->entry.args[0]) *arguments = info->entry.args;
    const struct call *call = NULL;
    into->path[0] = into->second[0] = 0;
    into->bytes = 0;
    if (info->entry.nr == SYS_mmap) {
        if ((int)arguments[4] < 0) return NULL;
        read_link(thread, (int)arguments[4], into->path, MAX_PATH);
        into->bytes = arguments[1];
        return &MAP;
    }
    for (size_t i = 0; i < sizeof CALLS / sizeof *CALLS && !call; i++)
        if (CALLS[i].number == (long)info->entry.nr) call = &CALLS[i];
    if (!call) return NULL;
    switch (call->form) {
    case F: read_link(thread, (int)arguments[0], into->path, MAX_PATH); break;
    case P: read_path(thread, AT_FDCWD, arguments[0], into->path); break;
    case A: read_path(thread, (int)arguments[0], arguments[1], into->path); break;
    case PP:
        read_path(thread, AT_FDCWD, arguments[0], into->path);
        read_path(thread, AT_FDCWD, arguments[1], into->second);
        break;
    case AA:
        read_path(thread, (int)arguments[0], arguments[1], into->path);
        read_path(thread, (int)arguments[2], arguments[3], into->second);
        break;
    }
    if (call->moves) into->bytes = arguments[2];
    /* For 'open', the bytes record whether the call may create a file. */
    if (!strcmp(call->name, "open")) into->bytes = (call->form == P ? arguments[1] : arguments[2]) & O_CREAT;
    return call;
}

int main(int count, char **words) {
    if (count < 6) {
        fprintf(stderr, "inject LOG NEEDLE NUMBER FAULT PROGRAM ARGUMENT...\n");
        return UNTRACEABLE;
    }
    FILE *log = fopen(words[1], "we");
    const char *needle = words[2], *fault = words[4];
    const long chosen = atol(words[3]);
    const char *value = strchr(fault, '=');
    const int error = value ? atoi(value + 1) : 0;
    const int lasts = !strncmp(fault, "full=", 5);
    if (!log) return UNTRACEABLE;

    pid_t program = fork();
    if (program < 0) return UNTRACEABLE;
    if (program == 0) {
        if (ptrace(PTRACE_TRACEME, 0, 0, 0)) _exit(UNTRACEABLE);
        raise(SIGSTOP);
        execvp(words[5], words + 5);
        _exit(UNTRACEABLE);
    }
    int status;
    if (waitpid(program, &status, 0) != program || !WIFSTOPPED(status)) return UNTRACEABLE;
    long options = PTRACE_O_TRACESYSGOOD | PTRACE_O_TRACECLONE | PTRACE_O_TRACEFORK | PTRACE_O_TRACEVFORK
                 | PTRACE_O_TRACEEXEC | PTRACE_O_EXITKILL;
    if (ptrace(PTRACE_SETOPTIONS, program, 0, options) || ptrace(PTRACE_SYSCALL, program, 0, 0)) return UNTRACEABLE;

    long number = 0;
    for (;;) {
        pid_t thread = waitpid(-1, &status, __WALL);
        if (thread < 0) return UNTRACEABLE;
        if (WIFEXITED(status) || WIFSIGNALED(status)) {
            struct pending *entry = pending_of(thread);
            if (entry && entry->thread == thread) entry->thread = 0;
            if (thread != program) continue;
            fclose(log);
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        }
        int signal = WSTOPSIG(status);
        if (signal != (SIGTRAP | 0x80)) {
            /* New threads start with SIGSTOP, events are SIGTRAP; other signals are passed on. */
            if (signal == SIGSTOP || signal == SIGTRAP) signal = 0;
            ptrace(PTRACE_SYSCALL, thread, 0, signal);
            continue;
        }
        struct __ptrace_syscall_info info;
        if (ptrace(PTRACE_GET_SYSCALL_INFO, thread, sizeof info, &info) <= 0) {
            if (errno == ESRCH) continue;
            kill(program, SIGKILL);
            return UNTRACEABLE;
        }
        struct pending *entry = pending_of(thread);
        if (info.op == PTRACE_SYSCALL_INFO_ENTRY && entry) {
            const struct call *call = find(thread, &info, entry);
            if (call && (strstr(entry->path, needle) || strstr(entry->second, needle))) {
                entry->thread = thread;
                entry->call = call;
                entry->result = entry->ends = 0;
                number++;
                const int grows = call->grows || (!strcmp(call->name, "open") && entry->bytes);
                if (number == chosen || (lasts && number > chosen && grows)) {
                    const uint64_t half = entry->bytes / 2;
                    if (error) {
                        entry->result = -error;
                        replace(thread, 1, NULL, NULL);
                    } else if (!strcmp(fault, "kill")) {
                        replace(thread, 1, NULL, NULL);
                        kill(program, SIGKILL);
                    } else if (!strcmp(fault, "torn") || !strcmp(fault, "short")) {
                        if (call->moves && entry->bytes > 1) replace(thread, 0, &half, NULL);
                        entry->ends = !strcmp(fault, "torn");
                    }
                }
            }
        } else if (info.op == PTRACE_SYSCALL_INFO_EXIT && entry && entry->thread == thread) {
            long result = entry->result ? entry->result : (long)info.exit.rval;
            if (entry->result) replace(thread, 0, NULL, &result);
            fprintf(log, "%s\t%s\t%s\t%llu\t%ld\n", entry->call->name, entry->path, entry->second,
                    (unsigned long long)entry->bytes, result);
            fflush(log);
            if (entry->ends) kill(program, SIGKILL);
            entry->thread = 0;
        }
        ptrace(PTRACE_SYSCALL, thread, 0, 0);
    }
}
