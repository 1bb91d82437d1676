/* Hits and Mrays per CPU-second of Embree's single-ray calls on the files of one scene that
 * `cargo bench --bench rays -- --export DIR` writes; scripts/embree-compare.py compiles and runs it.
 *
 *     embree-rays SCENE_DIRECTORY
 *
 * Prints one line for the build (CPU-seconds) and one a set: index, hits, Mrays per CPU-second (best of
 * seven rounds). One thread, Embree's default build quality. The few declarations below are
 * those of Embree 4's public interface, because Python packages of Embree bring no headers.
 */
#define _POSIX_C_SOURCE 200809L
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <time.h>

typedef struct Device *RTCDevice;
typedef struct Scene *RTCScene;
typedef struct Geometry *RTCGeometry;

struct Ray {
    float origin[3], t_near, direction[3], time, t_far;
    unsigned mask, id, flags;
} __attribute__((aligned(16)));

struct RayHit {
    struct Ray ray;
    float normal[3], u, v;
    unsigned primitive, geometry, instance[2], padding[3];
} __attribute__((aligned(16)));

RTCDevice rtcNewDevice(const char *config);
RTCScene rtcNewScene(RTCDevice device);
RTCGeometry rtcNewGeometry(RTCDevice device, int type);
void *rtcSetNewGeometryBuffer(RTCGeometry geometry, int type, unsigned slot, int format,
                              size_t stride, size_t count);
void rtcCommitGeometry(RTCGeometry geometry);
unsigned rtcAttachGeometry(RTCScene scene, RTCGeometry geometry);
void rtcCommitScene(RTCScene scene);
void rtcIntersect1(RTCScene scene, struct RayHit *hit, void *arguments);
void rtcOccluded1(RTCScene scene, struct Ray *ray, void *arguments);

enum { TRIANGLES = 0, INDICES = 0, VERTICES = 1, UINT3 = 0x5003, FLOAT3 = 0x9003, ROUNDS = 7 };

static double cpu_seconds(void) {
    struct timespec t;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &t);
    return (double)t.tv_sec + 1e-9 * (double)t.tv_nsec;
}

static void *read_file(const char *directory, const char *name, size_t *bytes) {
    char path[4096];
    snprintf(path, sizeof path, "%s/%s", directory, name);
    FILE *file = fopen(path, "rb");
    if (!file) {
        perror(path);
        exit(1);
    }
    fseek(file, 0, SEEK_END);
    *bytes = (size_t)ftell(file);
    rewind(file);
    void *data = malloc(*bytes + 1);
    if (!data || fread(data, 1, *bytes, file) != *bytes) {
        fprintf(stderr, "%s: cannot be read\n", path);
        exit(1);
    }
    ((char *)data)[*bytes] = 0;
    fclose(file);
    return data;
}

/* Fills one buffer of a geometry from a file of three-component items. */
static void fill(RTCGeometry geometry, int type, int format, const char *directory,
                 const char *name) {
    size_t bytes;
    void *data = read_file(directory, name, &bytes);
    memcpy(rtcSetNewGeometryBuffer(geometry, type, 0, format, 12, bytes / 12), data, bytes);
    free(data);
}

static size_t cast(RTCScene scene, const float *rays, size_t count, int any) {
    size_t hits = 0;
    for (size_t i = 0; i < count; i++) {
        const float *r = rays + 8 * i;
        struct RayHit hit = {.geometry = ~0u, .instance = {~0u, ~0u}};
        memcpy(hit.ray.origin, r, 12);
        memcpy(hit.ray.direction, r + 3, 12);
        hit.ray.t_near = r[6];
        hit.ray.t_far = r[7];
        hit.ray.mask = ~0u;
        if (any) {
            rtcOccluded1(scene, &hit.ray, NULL);
            hits += hit.ray.t_far < 0.0f;
        } else {
            rtcIntersect1(scene, &hit, NULL);
            hits += hit.geometry != ~0u;
        }
    }
    return hits;
}

int main(int count, char **arguments) {
    if (count != 2) {
        fprintf(stderr, "usage: %s SCENE_DIRECTORY\n", arguments[0]);
        return 2;
    }
    const char *directory = arguments[1];
    RTCDevice device = rtcNewDevice("threads=1,set_affinity=0");
    RTCScene scene = rtcNewScene(device);
    RTCGeometry geometry = rtcNewGeometry(device, TRIANGLES);
    fill(geometry, VERTICES, FLOAT3, directory, "positions.f32");
    fill(geometry, INDICES, UINT3, directory, "triangles.u32");
    rtcCommitGeometry(geometry);
    rtcAttachGeometry(scene, geometry);
    double start = cpu_seconds();
    rtcCommitScene(scene);
    printf("build\t%.4f\n", cpu_seconds() - start);

    size_t bytes;
    char *line = read_file(directory, "sets.tsv", &bytes);
    for (line = strtok(line, "\n"); line; line = strtok(NULL, "\n")) {
        unsigned index;
        char kind[16], name[32];
        if (sscanf(line, "%u\t%15s", &index, kind) != 2)
            continue;
        snprintf(name, sizeof name, "%u.f32", index);
        float *rays = read_file(directory, name, &bytes);
        size_t rays_count = bytes / 32, hits = 0;
        double best = 1e30;
        for (int round = 0; round < ROUNDS; round++) {
            start = cpu_seconds();
            hits = cast(scene, rays, rays_count, strcmp(kind, "any") == 0);
            double seconds = cpu_seconds() - start;
            best = seconds < best ? seconds : best;
        }
        printf("%u\t%zu\t%.4f\n", index, hits, (double)rays_count * 1e-6 / best);
        free(rays);
    }
    return 0;
}
