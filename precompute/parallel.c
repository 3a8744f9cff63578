#define _POSIX_C_SOURCE 200809L
#include "parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { THREAD_LIMIT = 256 };

typedef struct crew {
    al_piece_fn *work;
    void *user;
    unsigned count;
    atomic_uint next;
    atomic_bool stopped;
} crew;

typedef struct member {
    crew *crew;
    unsigned thread;
} member;

static void *run(void *user)
{
    member *self = user;
    crew *team = self->crew;
    while (!atomic_load(&team->stopped)) {
        unsigned piece = atomic_fetch_add(&team->next, 1);
        if (piece >= team->count) break;
        if (!team->work(team->user, piece, self->thread)) atomic_store(&team->stopped, true);
    }
    return NULL;
}

unsigned al_parallel_threads(unsigned threads)
{
    long cores = sysconf(_SC_NPROCESSORS_ONLN);
    unsigned wanted = threads ? threads : cores > 0 ? (unsigned)cores : 1;
    return wanted < THREAD_LIMIT ? wanted : THREAD_LIMIT;
}

bool al_parallel(unsigned threads, unsigned count, al_piece_fn *work, void *user)
{
    crew team = {.work = work, .user = user, .count = count};
    member members[THREAD_LIMIT];
    pthread_t handles[THREAD_LIMIT];
    unsigned started = 0, wanted = al_parallel_threads(threads);
    atomic_init(&team.next, 0);
    atomic_init(&team.stopped, false);
    for (unsigned i = 0; i < wanted; i++) members[i] = (member){&team, i};
    /* A thread that cannot be started is not missed: the others take its pieces. */
    for (unsigned i = 1; i < wanted && i < count; i++)
        if (pthread_create(&handles[started], NULL, run, &members[i]) == 0) started++;
    run(&members[0]);
    for (unsigned i = 0; i < started; i++) pthread_join(handles[i], NULL);
    return !atomic_load(&team.stopped);
}
