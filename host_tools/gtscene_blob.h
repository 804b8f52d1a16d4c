/* The scene blob (SPEC.md, "Scene blob"): assembled and measured. */
#ifndef GTSCENE_BLOB_H
#define GTSCENE_BLOB_H

#include "gtscene_desc.h"
#include "gtscene_meshlets.h"

/* Builds all meshes and lays out the blob: malloc'd, *bytes long, accepted by scene_open. The same description and
 * mesh files give the same bytes. Dies with EXIT_BAD_INPUT when a limit is passed. */
void *blob_build(size_t *bytes, const struct scene_desc *desc, const struct pack_options *options);

/* What `gtscene info` prints, to stdout. */
void blob_print(const struct scene *s);

#endif
