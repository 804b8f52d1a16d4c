#include "host_parallel.h"

#include <pthread.h>
#include <stdatomic.h>
#include <unistd.h>

enum { MAX_THREADS = 64 };

struct loop {
    int count;
    void (*body)(void *ctx, int i);
    void *ctx;
    atomic_int next;
};

static void *run(void *p)
{
    struct loop *loop = p;
    for (int i; (i = atomic_fetch_add(&loop->next, 1)) < loop->count;)
        loop->body(loop->ctx, i);
    return NULL;
}

void parallel_for(int threads, int count, void (*body)(void *ctx, int i), void *ctx)
{
    struct loop loop = {.count = count, .body = body, .ctx = ctx};
    pthread_t helpers[MAX_THREADS];
    int started = 0;
    if (!threads)
        threads = (int)sysconf(_SC_NPROCESSORS_ONLN);
    while (started + 1 < threads && started < MAX_THREADS && !pthread_create(&helpers[started], NULL, run, &loop))
        started++;
    run(&loop);
    while (started-- > 0)
        pthread_join(helpers[started], NULL);
}
