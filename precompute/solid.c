/* Embree finds every crossing of a ray from the point with the surface. The faces that it leaves through less
 * those it enters through are the winding number about the point, which is above 0 inside, whichever way the
 * ray goes and also where the surface cuts itself. */
#include "solid.h"

#include <math.h>
#include <stdlib.h>

#include <embree3/rtcore.h>

struct al_solid {
    RTCDevice device;
    RTCScene scene;
    double centre[3];
};

/* Off every plane that a modelled face is likely to lie in. */
static const float way[3] = {0.5345225f, 0.2672612f, 0.8017837f};

static void copy_triangles(const al_triangles *triangles, RTCGeometry geometry, double centre[3])
{
    float *vertices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_VERTEX, 0, RTC_FORMAT_FLOAT3,
                                              3 * sizeof(float), triangles->vertex_count);
    uint32_t *indices = rtcSetNewGeometryBuffer(geometry, RTC_BUFFER_TYPE_INDEX, 0, RTC_FORMAT_UINT3,
                                                3 * sizeof(uint32_t), triangles->triangle_count);
    if (!vertices || !indices) return;
    for (int k = 0; k < 3; k++) {
        double low = INFINITY, high = -INFINITY;
        for (size_t i = 0; i < triangles->vertex_count; i++) {
            low = fmin(low, triangles->positions[3 * i + k]);
            high = fmax(high, triangles->positions[3 * i + k]);
        }
        centre[k] = 0.5 * (low + high);
    }
    for (size_t i = 0; i < 3 * (size_t)triangles->vertex_count; i++)
        vertices[i] = (float)(triangles->positions[i] - centre[i % 3]);
    for (size_t i = 0; i < 3 * (size_t)triangles->triangle_count; i++) indices[i] = triangles->indices[i];
}

al_status al_solid_create(const al_triangles *triangles, al_solid **solid, al_error *error)
{
    *solid = NULL;
    al_solid *made = calloc(1, sizeof *made);
    if (!made) return al_fail(error, AL_IO, "out of memory for a solid");
    made->device = rtcNewDevice(NULL);
    made->scene = made->device ? rtcNewScene(made->device) : NULL;
    if (made->scene) {
        rtcSetSceneFlags(made->scene, RTC_SCENE_FLAG_ROBUST | RTC_SCENE_FLAG_CONTEXT_FILTER_FUNCTION);
        RTCGeometry geometry = rtcNewGeometry(made->device, RTC_GEOMETRY_TYPE_TRIANGLE);
        if (triangles->triangle_count) copy_triangles(triangles, geometry, made->centre);
        rtcCommitGeometry(geometry);
        rtcAttachGeometry(made->scene, geometry);
        rtcReleaseGeometry(geometry);
        rtcCommitScene(made->scene);
    }
    enum RTCError code = rtcGetDeviceError(made->device);
    if (code == RTC_ERROR_NONE) {
        *solid = made;
        return AL_OK;
    }
    al_solid_free(made);
    return al_fail(error, AL_IO, "Embree cannot build a solid: error %d", (int)code);
}

void al_solid_free(al_solid *solid)
{
    if (!solid) return;
    if (solid->scene) rtcReleaseScene(solid->scene);
    if (solid->device) rtcReleaseDevice(solid->device);
    free(solid);
}

typedef struct counting {
    struct RTCIntersectContext base; /* first: Embree hands this to the filter */
    int winding;
} counting;

/* Counts every hit and refuses it, so that Embree goes on to the next. */
static void on_hit(const struct RTCFilterFunctionNArguments *arguments)
{
    const struct RTCHit *hit = (const struct RTCHit *)arguments->hit;
    float leaving = hit->Ng_x * way[0] + hit->Ng_y * way[1] + hit->Ng_z * way[2];
    ((counting *)arguments->context)->winding += leaving > 0 ? 1 : -1;
    arguments->valid[0] = 0;
}

bool al_solid_contains(const al_solid *solid, const double point[3])
{
    counting context = {.winding = 0};
    struct RTCRayHit ray = {.ray = {.tnear = 0, .tfar = INFINITY, .mask = ~0u}};
    rtcInitIntersectContext(&context.base);
    context.base.filter = on_hit;
    ray.ray.org_x = (float)(point[0] - solid->centre[0]);
    ray.ray.org_y = (float)(point[1] - solid->centre[1]);
    ray.ray.org_z = (float)(point[2] - solid->centre[2]);
    ray.ray.dir_x = way[0];
    ray.ray.dir_y = way[1];
    ray.ray.dir_z = way[2];
    ray.hit.geomID = RTC_INVALID_GEOMETRY_ID;
    rtcIntersect1(solid->scene, &context.base, &ray);
    return context.winding > 0;
}
