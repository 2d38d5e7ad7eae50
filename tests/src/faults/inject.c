/* Runs a program and lets one of its system calls on files fail, or ends it there.
 *
 *   inject LOG NEEDLE NUMBER FAULT PROGRAM ARGUMENT...
 *
 * Calls that touch a path with NEEDLE in it, or a descriptor of such a path, are numbered from 1 over all threads. What
 * happens at call NUMBER is FAULT:
 *
 *   none        nothing; 0 as NUMBER suits it
 *   kill        SIGKILL, and the call is not made
 *   torn        a write writes half of its bytes, then SIGKILL; other calls are made, then SIGKILL
 *   short       a read or write moves half of its bytes
 *   errno=N     the call is not made and fails with N
 *   full=N      as errno=N, and so do all later calls that make a file, make it longer, or sync it
 *
 * LOG gets a line for each numbered call: name, path, second path, bytes asked for, result; between them tabs.
 * Exits as the program does; with 137 where it was killed, with 125 where this machine does not let it be traced.
 *
 * By ptrace, so that it does not matter how the program makes its calls: some libraries make them without libc.
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

enum { UNTRACEABLE = 125, KILLED = 137, PATH_MOST = 4096, THREADS_MOST = 256 };

/* Where a call names its file: by a descriptor (F), a path (P), a folder and a path (A), two of these. */
enum form { F, P, A, PP, AA };

struct call {
    long number;
    const char *name;
    enum form form;
    int moves;  /* bytes, as many as the third argument says */
    int grows;  /* may need room on the disk */
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

/* mmap has its descriptor in the fifth argument. */
static const struct call MAP = {SYS_mmap, "map", F, 0, 0};

/* A numbered call that a thread is in. */
struct pending {
    pid_t thread;
    const struct call *call;
    char path[PATH_MOST], second[PATH_MOST];
    uint64_t bytes;
    int result;  /* to report instead of the call's own; 0 for none */
    int ends;    /* the program is killed once the call is made */
};

static struct pending PENDING[THREADS_MOST];

static struct pending *pending_of(pid_t thread) {
    struct pending *free_one = NULL;
    for (int i = 0; i < THREADS_MOST; i++) {
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
#error "this processor's registers are not known here"
#endif

/* A string of the program, a page at a time, as the next page may not be there. */
static void read_string(pid_t thread, uint64_t address, char *to, size_t most) {
    size_t length = 0;
    while (length + 1 < most) {
        size_t step = 4096 - (address + length) % 4096;
        if (step > most - 1 - length) step = most - 1 - length;
        struct iovec local = {to + length, step}, remote = {(void *)(uintptr_t)(address + length), step};
        ssize_t read = process_vm_readv(thread, &local, 1, &remote, 1, 0);
        if (read <= 0) break;
        if (memchr(to + length, 0, (size_t)read)) return;
        length += (size_t)read;
    }
    to[length] = 0;
}

/* What a link of /proc leads to: a descriptor's file, or the current folder. */
static void read_place(pid_t thread, int descriptor, char *to, size_t most) {
    char link[64];
    if (descriptor == AT_FDCWD) snprintf(link, sizeof link, "/proc/%d/cwd", (int)thread);
    else snprintf(link, sizeof link, "/proc/%d/fd/%d", (int)thread, descriptor);
    ssize_t length = readlink(link, to, most - 1);
    to[length > 0 ? length : 0] = 0;
}

static void read_path(pid_t thread, int folder, uint64_t address, char *to) {
    char path[PATH_MOST];
    read_string(thread, address, path, sizeof path);
    if (path[0] == '/') {
        memcpy(to, path, PATH_MOST);
        return;
    }
    read_place(thread, folder, to, PATH_MOST);
    size_t length = strlen(to);
    if (path[0]) snprintf(to + length, PATH_MOST - length, "/%s", path);
}

/* The call that a thread is about to make, if it is one of ours, with its paths. */
static const struct call *find(pid_t thread, const struct __ptrace_syscall_info *info, struct pending *into) {
    const __typeof__(info->entry.args[0]) *arguments = info->entry.args;
    const struct call *call = NULL;
    into->path[0] = into->second[0] = 0;
    into->bytes = 0;
    if (info->entry.nr == SYS_mmap) {
        if ((int)arguments[4] < 0) return NULL;
        read_place(thread, (int)arguments[4], into->path, PATH_MOST);
        into->bytes = arguments[1];
        return &MAP;
    }
    for (size_t i = 0; i < sizeof CALLS / sizeof *CALLS && !call; i++)
        if (CALLS[i].number == (long)info->entry.nr) call = &CALLS[i];
    if (!call) return NULL;
    switch (call->form) {
    case F: read_place(thread, (int)arguments[0], into->path, PATH_MOST); break;
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
    /* What may make a file is told apart from what only opens one. */
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
            struct pending *slot = pending_of(thread);
            if (slot && slot->thread == thread) slot->thread = 0;
            if (thread != program) continue;
            fclose(log);
            return WIFEXITED(status) ? WEXITSTATUS(status) : 128 + WTERMSIG(status);
        }
        int signal = WSTOPSIG(status);
        if (signal != (SIGTRAP | 0x80)) {
            /* New threads begin with a stop, and events are traps; other signals are the program's own. */
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
        struct pending *slot = pending_of(thread);
        if (info.op == PTRACE_SYSCALL_INFO_ENTRY && slot) {
            const struct call *call = find(thread, &info, slot);
            if (call && (strstr(slot->path, needle) || strstr(slot->second, needle))) {
                slot->thread = thread;
                slot->call = call;
                slot->result = slot->ends = 0;
                number++;
                const int grows = call->grows || (!strcmp(call->name, "open") && slot->bytes);
                if (number == chosen || (lasts && number > chosen && grows)) {
                    const uint64_t half = slot->bytes / 2;
                    if (error) {
                        slot->result = -error;
                        replace(thread, 1, NULL, NULL);
                    } else if (!strcmp(fault, "kill")) {
                        replace(thread, 1, NULL, NULL);
                        kill(program, SIGKILL);
                    } else if (!strcmp(fault, "torn") || !strcmp(fault, "short")) {
                        if (call->moves && slot->bytes > 1) replace(thread, 0, &half, NULL);
                        slot->ends = !strcmp(fault, "torn");
                    }
                }
            }
        } else if (info.op == PTRACE_SYSCALL_INFO_EXIT && slot && slot->thread == thread) {
            long result = slot->result ? slot->result : (long)info.exit.rval;
            if (slot->result) replace(thread, 0, NULL, &result);
            fprintf(log, "%s\t%s\t%s\t%llu\t%ld\n", slot->call->name, slot->path, slot->second,
                    (unsigned long long)slot->bytes, result);
            fflush(log);
            if (slot->ends) kill(program, SIGKILL);
            slot->thread = 0;
        }
        ptrace(PTRACE_SYSCALL, thread, 0, 0);
    }
}
