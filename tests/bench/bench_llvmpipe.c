/*
 * Times Mesa's llvmpipe and this renderer in turn on the same frame: six torus knots under three directional lights (the scene
 * host_tools/scenes/six_knots.json), without levels of detail.
 *
 *   bench_llvmpipe WIDTH HEIGHT THREADS SCENE.blob FRAME.ktx2 TABLE.ktx2...
 *
 * llvmpipe evaluates FRAME, a specular-frame table of 361 x 181 x 4 at theta_in 0, 20, 40 and 60 degrees, in its fragment shader as a GPU
 * would: a 3-D texture in RGB9_E5, filtered in three dimensions. This renderer shades with each TABLE. Both rasterize in THREADS threads.
 * One line per table: `table FILE ms VALUE llvmpipe_ms VALUE over_llvmpipe RATIO`, the least of many frames.
 * Fails when both do not cover the same number of pixels within 1 %.
 */
#define _GNU_SOURCE
#define GL_GLEXT_PROTOTYPES
#include "common.h"
#include "raster.h"

#include <EGL/egl.h>
#include <EGL/eglext.h>
#include <GL/gl.h>
#include <GL/glext.h>
#include <math.h>
#include <pthread.h>
#include <stdatomic.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

enum { RINGS = 256, SIDES = 16, KNOTS = 6, INDICES = RINGS * SIDES * 6 };
enum { TABLE_PHI = 361, TABLE_THETA = 181, TABLE_IN = 4 };
enum { MAX_THREADS = 64, MAX_TABLES = 8, LEAST_FRAMES = 5, MOST_FRAMES = 60 };
static const double seconds_enough = 4;

static double milliseconds(void)
{
    struct timespec t;
    clock_gettime(CLOCK_MONOTONIC, &t);
    return 1e3 * (double)t.tv_sec + 1e-6 * (double)t.tv_nsec;
}

/* --- llvmpipe --- */

struct vertex {
    float position[3], normal[3];
};

static void curve_point(double p[3], double t)
{
    const double r = 1.16 + 0.50 * cos(3 * t);
    p[0] = r * cos(2 * t);
    p[1] = r * sin(2 * t);
    p[2] = 0.75 * sin(3 * t);
}

static void normalize(double v[3])
{
    const double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
    for (int k = 0; k < 3; k++)
        v[k] /= length;
}

/* A closed (2,3) torus knot: RINGS rings of SIDES vertices around its curve. */
static void knot_make(struct vertex *v, uint16_t *index)
{
    const double tube = 0.52, scale = 0.46;
    for (int i = 0; i < RINGS; i++) {
        const double t = 2 * M_PI * i / RINGS;
        double p[3], next[3], along[3];
        curve_point(p, t);
        curve_point(next, t + 1e-5);
        for (int k = 0; k < 3; k++)
            along[k] = next[k] - p[k];
        normalize(along);
        double side[3] = {along[1], -along[0], 0}; /* along x z */
        normalize(side);
        const double up[3] = {side[1] * along[2] - side[2] * along[1], side[2] * along[0] - side[0] * along[2],
                              side[0] * along[1] - side[1] * along[0]};
        for (int j = 0; j < SIDES; j++) {
            const double a = 2 * M_PI * j / SIDES;
            struct vertex *out = v + i * SIDES + j;
            for (int k = 0; k < 3; k++) {
                const double n = cos(a) * up[k] + sin(a) * side[k];
                out->normal[k] = (float)n;
                out->position[k] = (float)((p[k] + tube * n) * scale);
            }
            const int a0 = i * SIDES + j, b0 = i * SIDES + (j + 1) % SIDES;
            const int a1 = (i + 1) % RINGS * SIDES + j, b1 = (i + 1) % RINGS * SIDES + (j + 1) % SIDES;
            const int corners[6] = {a0, b0, a1, a1, b0, b1};
            for (int k = 0; k < 6; k++)
                *index++ = (uint16_t)corners[k];
        }
    }
}

static const char vertex_source[] =
    "#version 330 core\n"
    "layout(location = 0) in vec3 position;\n"
    "layout(location = 1) in vec3 direction;\n"
    "uniform float aspect;\n"
    "out vec3 eye, normal;\n"
    "void main() {\n"
    "    int i = gl_InstanceID;\n"
    "    float a = 0.9 * float(i), b = 0.35 - 0.25 * float(i);\n"
    "    mat3 turn = mat3(cos(a), sin(a), 0, -sin(a), cos(a), 0, 0, 0, 1) *\n"
    "                mat3(1, 0, 0, 0, cos(b), sin(b), 0, -sin(b), cos(b));\n"
    "    eye = turn * position + vec3(float(i % 3 - 1) * 1.95, float(i / 3) * 1.9 - 0.95, -5.0);\n"
    "    normal = turn * direction;\n"
    "    const float focal = 2.41421356, near = 1.0, far = 20.0;\n"
    "    gl_Position = vec4(focal / aspect * eye.x, focal * eye.y,\n"
    "                       ((near + far) * eye.z + 2.0 * near * far) / (near - far), -eye.z);\n"
    "}\n";

/* The table's frame has x along the light's projection and z along the normal; turned about its y axis by theta_in, the mirror
 * direction (-sin, 0, cos) is the pole. */
static const char fragment_source[] =
    "#version 330 core\n"
    "in vec3 eye, normal;\n"
    "out vec4 colour;\n"
    "uniform sampler3D table;\n"
    "const float PI = 3.14159265358979;\n"
    "vec3 brdf(vec3 n, vec3 v, vec3 l, float cos_in) {\n"
    "    float sin_in = sqrt(max(1.0 - cos_in * cos_in, 1e-12));\n"
    "    vec3 x = (l - cos_in * n) / sin_in, y = cross(n, x);\n"
    "    vec3 w = vec3(dot(v, x), dot(v, y), dot(v, n));\n"
    "    vec3 d = vec3(cos_in * w.x + sin_in * w.z, w.y, cos_in * w.z - sin_in * w.x);\n"
    "    float phi = atan(d.y, d.x), theta = acos(clamp(d.z, -1.0, 1.0)), theta_in = acos(min(cos_in, 1.0));\n"
    "    vec3 at = vec3(phi * (180.0 / PI) + 180.5, theta * (180.0 / PI) + 0.5, theta_in * (9.0 / PI) + 0.5);\n"
    "    return texture(table, at / vec3(361.0, 181.0, 4.0)).rgb;\n"
    "}\n"
    "vec3 reflected(vec3 n, vec3 v, vec3 l, vec3 irradiance) {\n"
    "    float cos_in = dot(n, l);\n"
    "    if (cos_in <= 0.0) return vec3(0.0);\n"
    "    return irradiance * cos_in * brdf(n, v, l, cos_in);\n"
    "}\n"
    "void main() {\n"
    "    vec3 n = normalize(normal), v = normalize(-eye);\n"
    "    vec3 sum = reflected(n, v, vec3(0.57735, 0.57735, 0.57735), vec3(1.6, 1.5, 1.35));\n"
    "    sum += reflected(n, v, vec3(-0.81650, 0.40825, 0.40825), vec3(0.55, 0.70, 1.20));\n"
    "    sum += reflected(n, v, vec3(0.0, -0.70711, 0.70711), vec3(0.8, 0.5, 0.35));\n"
    "    colour = vec4(sqrt(clamp(sum, 0.0, 1.0)), 1.0);\n"
    "}\n";

static GLuint shader_compile(GLenum kind, const char *source)
{
    GLuint s = glCreateShader(kind);
    GLint compiled;
    glShaderSource(s, 1, &source, NULL);
    glCompileShader(s);
    glGetShaderiv(s, GL_COMPILE_STATUS, &compiled);
    if (!compiled) {
        char log[2048];
        glGetShaderInfoLog(s, sizeof log, NULL, log);
        die(EXIT_INTERNAL, "llvmpipe: %s", log);
    }
    return s;
}

/* Off screen, with that many threads. */
static void context_open(const char *threads)
{
    setenv("LIBGL_ALWAYS_SOFTWARE", "1", 1);
    setenv("GALLIUM_DRIVER", "llvmpipe", 1);
    setenv("LP_NUM_THREADS", threads, 1);
    PFNEGLGETPLATFORMDISPLAYEXTPROC display_of =
        (PFNEGLGETPLATFORMDISPLAYEXTPROC)eglGetProcAddress("eglGetPlatformDisplayEXT");
    EGLDisplay d = display_of ? display_of(EGL_PLATFORM_SURFACELESS_MESA, EGL_DEFAULT_DISPLAY, NULL) : EGL_NO_DISPLAY;
    if (d == EGL_NO_DISPLAY || !eglInitialize(d, NULL, NULL) || !eglBindAPI(EGL_OPENGL_API))
        die(EXIT_INTERNAL, "no surfaceless EGL display with OpenGL; install libgl1-mesa-dri");
    const EGLint version[] = {EGL_CONTEXT_MAJOR_VERSION, 3, EGL_CONTEXT_MINOR_VERSION, 3, EGL_NONE};
    EGLContext c = eglCreateContext(d, EGL_NO_CONFIG_KHR, EGL_NO_CONTEXT, version);
    if (c == EGL_NO_CONTEXT || !eglMakeCurrent(d, EGL_NO_SURFACE, EGL_NO_SURFACE, c))
        die(EXIT_INTERNAL, "no OpenGL 3.3 context");
    const char *renderer = (const char *)glGetString(GL_RENDERER);
    if (!renderer || strncmp(renderer, "llvmpipe", 8))
        die(EXIT_INTERNAL, "the renderer is %s, not llvmpipe", renderer ? renderer : "unknown");
    fprintf(stderr, "%s\n", renderer);
}

static void target_open(int width, int height)
{
    GLuint buffer, planes[2];
    glGenFramebuffers(1, &buffer);
    glBindFramebuffer(GL_FRAMEBUFFER, buffer);
    glGenRenderbuffers(2, planes);
    glBindRenderbuffer(GL_RENDERBUFFER, planes[0]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_RGBA8, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_COLOR_ATTACHMENT0, GL_RENDERBUFFER, planes[0]);
    glBindRenderbuffer(GL_RENDERBUFFER, planes[1]);
    glRenderbufferStorage(GL_RENDERBUFFER, GL_DEPTH_COMPONENT24, width, height);
    glFramebufferRenderbuffer(GL_FRAMEBUFFER, GL_DEPTH_ATTACHMENT, GL_RENDERBUFFER, planes[1]);
    if (glCheckFramebufferStatus(GL_FRAMEBUFFER) != GL_FRAMEBUFFER_COMPLETE)
        die(EXIT_INTERNAL, "no frame buffer of %d x %d", width, height);
    glViewport(0, 0, width, height);
    glEnable(GL_DEPTH_TEST);
    glEnable(GL_CULL_FACE);
    glClearColor(0.03f, 0.04f, 0.06f, 0);
}

static void table_upload(const struct lut_table *t)
{
    GLuint texture;
    glGenTextures(1, &texture);
    glBindTexture(GL_TEXTURE_3D, texture);
    glTexImage3D(GL_TEXTURE_3D, 0, GL_RGB9_E5, TABLE_PHI, TABLE_THETA, TABLE_IN, 0, GL_RGB, GL_UNSIGNED_INT_5_9_9_9_REV,
                 t->texels);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MIN_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_MAG_FILTER, GL_LINEAR);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_S, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_T, GL_CLAMP_TO_EDGE);
    glTexParameteri(GL_TEXTURE_3D, GL_TEXTURE_WRAP_R, GL_CLAMP_TO_EDGE);
}

static void mesh_upload(void)
{
    static struct vertex vertices[RINGS * SIDES];
    static uint16_t indices[INDICES];
    GLuint array, buffers[2];
    knot_make(vertices, indices);
    glGenVertexArrays(1, &array);
    glBindVertexArray(array);
    glGenBuffers(2, buffers);
    glBindBuffer(GL_ARRAY_BUFFER, buffers[0]);
    glBufferData(GL_ARRAY_BUFFER, sizeof vertices, vertices, GL_STATIC_DRAW);
    glBindBuffer(GL_ELEMENT_ARRAY_BUFFER, buffers[1]);
    glBufferData(GL_ELEMENT_ARRAY_BUFFER, sizeof indices, indices, GL_STATIC_DRAW);
    glVertexAttribPointer(0, 3, GL_FLOAT, GL_FALSE, sizeof *vertices, NULL);
    glVertexAttribPointer(1, 3, GL_FLOAT, GL_FALSE, sizeof *vertices, (void *)offsetof(struct vertex, normal));
    glEnableVertexAttribArray(0);
    glEnableVertexAttribArray(1);
}

static void program_use(float aspect)
{
    GLuint p = glCreateProgram();
    GLint linked;
    glAttachShader(p, shader_compile(GL_VERTEX_SHADER, vertex_source));
    glAttachShader(p, shader_compile(GL_FRAGMENT_SHADER, fragment_source));
    glLinkProgram(p);
    glGetProgramiv(p, GL_LINK_STATUS, &linked);
    if (!linked)
        die(EXIT_INTERNAL, "llvmpipe: the program does not link");
    glUseProgram(p);
    glUniform1i(glGetUniformLocation(p, "table"), 0);
    glUniform1f(glGetUniformLocation(p, "aspect"), aspect);
}

static double llvmpipe_frame(void)
{
    const double start = milliseconds();
    glClear(GL_COLOR_BUFFER_BIT | GL_DEPTH_BUFFER_BIT);
    glDrawElementsInstanced(GL_TRIANGLES, INDICES, GL_UNSIGNED_SHORT, NULL, KNOTS);
    glFinish();
    return milliseconds() - start;
}

static size_t llvmpipe_covered(int width, int height)
{
    const size_t pixels = (size_t)width * (size_t)height;
    uint8_t *rgba = xmalloc(4 * pixels);
    size_t covered = 0;
    glReadPixels(0, 0, width, height, GL_RGBA, GL_UNSIGNED_BYTE, rgba);
    for (size_t i = 0; i < pixels; i++)
        covered += rgba[4 * i + 3] != 0;
    free(rgba);
    if (glGetError() != GL_NO_ERROR)
        die(EXIT_INTERNAL, "llvmpipe reports an error");
    return covered;
}

/* --- ours: threads take tiles in turn --- */

struct job {
    struct raster raster;
    uint8_t *picture; /* RGB888 */
    atomic_uint next, covered;
};

static struct raster_tile works[MAX_THREADS];

struct worker {
    struct job *job;
    struct raster_tile *work;
};

static void *tiles_render(void *argument)
{
    const struct worker *w = argument;
    struct job *job = w->job;
    const size_t row_bytes = 3 * (size_t)job->raster.frame.width;
    unsigned covered = 0;
    for (uint32_t i; (i = atomic_fetch_add(&job->next, 1)) < raster_tile_count(&job->raster);) {
        struct raster_rect r;
        struct raster_stats stats;
        raster_render_tile(&job->raster, i, w->work, &r, &stats);
        covered += stats.covered;
        for (size_t y = 0; y < r.height; y++)
            memcpy(job->picture + (r.y + y) * row_bytes + 3u * r.x, raster_tile_pixels(w->work) + 3 * y * r.width,
                   3u * r.width);
    }
    atomic_fetch_add(&job->covered, covered);
    return NULL;
}

static double our_frame(struct job *job, const struct raster_frame *frame, void *arena, size_t arena_bytes, int threads)
{
    pthread_t ids[MAX_THREADS];
    struct worker workers[MAX_THREADS];
    const double start = milliseconds();
    job->next = job->covered = 0;
    enum raster_status status = raster_begin(&job->raster, frame, arena, arena_bytes);
    if (status != RASTER_OK)
        die(EXIT_INTERNAL, "frame: %s", raster_status_text(status));
    for (int i = 0; i < threads; i++)
        workers[i] = (struct worker){job, &works[i]};
    for (int i = 1; i < threads; i++)
        if (pthread_create(&ids[i], NULL, tiles_render, &workers[i]))
            die(EXIT_INTERNAL, "no thread");
    tiles_render(&workers[0]);
    for (int i = 1; i < threads; i++)
        pthread_join(ids[i], NULL);
    return milliseconds() - start;
}

static void table_open(struct lut_table *t, const char *path)
{
    size_t bytes;
    const void *file = read_file(path, 64u << 20, &bytes); /* stays */
    enum lut_status s = lut_open(t, file, bytes);
    if (s != LUT_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build it with gtlut", path, lut_status_text(s));
}

int main(int argc, char **argv)
{
    common_set_name("bench_llvmpipe", NULL);
    if (argc < 7 || argc - 6 > MAX_TABLES)
        die(EXIT_USAGE, "usage: bench_llvmpipe WIDTH HEIGHT THREADS SCENE.blob FRAME.ktx2 TABLE.ktx2...");
    const int width = (int)parse_long("WIDTH", argv[1], 1, RASTER_MAX_WIDTH);
    const int height = (int)parse_long("HEIGHT", argv[2], 1, RASTER_MAX_HEIGHT);
    const int threads = (int)parse_long("THREADS", argv[3], 1, MAX_THREADS), tables = argc - 6;
    size_t bytes;
    struct scene scene;
    const void *blob = read_file(argv[4], SCENE_MAX_BYTES, &bytes);
    enum scene_status opened = scene_open(&scene, blob, bytes);
    if (opened != SCENE_OK)
        die(EXIT_BAD_INPUT, "%s: %s; build it with gtscene", argv[4], scene_status_text(opened));
    static struct lut_table table[1 + MAX_TABLES];
    for (int i = 0; i <= tables; i++)
        table_open(&table[i], argv[5 + i]);
    if (table[0].kind != LUT_SPECULAR_FRAME || table[0].width != TABLE_PHI || table[0].height != TABLE_THETA ||
        table[0].depth != TABLE_IN)
        die(EXIT_BAD_INPUT, "%s: not a specular-frame table of 361 x 181 x 4", argv[5]);

    context_open(argv[3]);
    target_open(width, height);
    table_upload(&table[0]);
    mesh_upload();
    program_use((float)width / (float)height);

    const struct lut_table *slots[RASTER_MAX_SLOTS] = {&table[1]};
    const struct raster_frame frame = {.parts = &raster_all_parts,
                                       .scene = &scene,
                                       .camera = &scene.header->camera,
                                       .output = &scene.header->output,
                                       .lights = scene.lights,
                                       .materials = scene.materials,
                                       .tables = slots,
                                       .width = (uint16_t)width,
                                       .height = (uint16_t)height,
                                       .light_count = (uint8_t)scene.header->lights.count,
                                       .format = RASTER_RGB888};
    const size_t arena_bytes = raster_arena_bytes(&frame);
    void *arena = xmalloc(arena_bytes);
    static struct job job;
    job.picture = xmalloc((size_t)width * (size_t)height * 3);

    llvmpipe_frame(); /* compiles the shaders */
    double least[1 + MAX_TABLES];
    for (int i = 0; i <= tables; i++)
        least[i] = INFINITY;
    const double start = milliseconds();
    for (int n = 0; n < LEAST_FRAMES || (n < MOST_FRAMES && milliseconds() - start < 1e3 * seconds_enough); n++) {
        least[0] = fmin(least[0], llvmpipe_frame());
        for (int i = 1; i <= tables; i++) {
            slots[0] = &table[i];
            least[i] = fmin(least[i], our_frame(&job, &frame, arena, arena_bytes, threads));
        }
    }
    const double theirs = (double)llvmpipe_covered(width, height), ours = job.covered;
    if (fabs(theirs - ours) > 0.01 * theirs)
        die(EXIT_MISMATCH, "llvmpipe covers %.0f pixels, this renderer %.0f: not the same frame", theirs, ours);
    for (int i = 1; i <= tables; i++)
        printf("table %s ms %.3f llvmpipe_ms %.3f over_llvmpipe %.3f\n", argv[5 + i], least[i], least[0],
               least[i] / least[0]);
    return EXIT_OK;
}
