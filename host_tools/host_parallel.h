/*
 * A loop whose turns do not depend on one another, on several threads.
 */
#ifndef HOST_TOOLS_HOST_PARALLEL_H
#define HOST_TOOLS_HOST_PARALLEL_H

/* Calls body(ctx, i) for each i from 0 to count-1 once, in any order. threads: at least 1; 0: as many as there are processors. */
void parallel_for(int threads, int count, void (*body)(void *ctx, int i), void *ctx);

#endif
