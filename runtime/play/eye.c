#include "eye.h"

#include <cglm/cglm.h>
#include <math.h>
#include <string.h>

al_bounds al_bounds_of_scene(const al_scene *scene)
{
    al_bounds bounds = {{INFINITY, INFINITY, INFINITY}, {-INFINITY, -INFINITY, -INFINITY}};
    for (uint32_t i = 0; i < scene->instance_count; i++) {
        const al_instance *instance = &scene->instances[i];
        const al_mesh *mesh = &scene->meshes[instance->mesh];
        if (instance->role == AL_ROLE_BLOCKER) continue;
        for (uint32_t v = 0; v < mesh->vertex_count; v++)
            for (int row = 0; row < 3; row++) {
                const float *m = instance->world + row, *p = mesh->positions + 3 * (size_t)v;
                float at = m[0] * p[0] + m[4] * p[1] + m[8] * p[2] + m[12];
                bounds.low[row] = fminf(bounds.low[row], at);
                bounds.high[row] = fmaxf(bounds.high[row], at);
            }
    }
    return bounds;
}

static bool is_empty(const al_bounds *bounds)
{
    return !(bounds->low[0] <= bounds->high[0]);
}

/* An up axis that is not along the view. */
static void sane_up(const vec3 forward, const vec3 wished, vec3 up)
{
    vec3 side, from = {forward[0], forward[1], forward[2]};
    glm_vec3_copy((float *)wished, up);
    glm_vec3_cross(from, up, side);
    if (glm_vec3_norm(side) > 1e-4f * glm_vec3_norm(from)) return;
    glm_vec3_copy(fabsf(up[1]) > 0.9f * glm_vec3_norm(up) ? (vec3){0, 0, -1} : (vec3){0, 1, 0}, up);
}

al_eye al_eye_from_camera(const al_camera *camera)
{
    al_eye eye = {.fov_y_radians = camera->fov_y_radians};
    vec3 forward;
    memcpy(eye.position, camera->position, sizeof eye.position);
    memcpy(eye.target, camera->target, sizeof eye.target);
    glm_vec3_sub(eye.target, eye.position, forward);
    sane_up(forward, camera->up, eye.up);
    glm_vec3_normalize(eye.up);
    return eye;
}

void al_eye_frame(al_eye *eye, const al_bounds *bounds)
{
    if (is_empty(bounds)) return;
    vec3 forward, half;
    glm_vec3_sub(eye->target, eye->position, forward);
    glm_vec3_normalize(forward);
    glm_vec3_center((float *)bounds->low, (float *)bounds->high, eye->target);
    glm_vec3_sub((float *)bounds->high, eye->target, half);
    float distance = glm_vec3_norm(half) / sinf(0.5f * eye->fov_y_radians);
    for (int i = 0; i < 3; i++) eye->position[i] = eye->target[i] - distance * forward[i];
}

/* Turns `arm` by yaw about up and by pitch about its side; stays a degree away from the poles. */
static void turn(const vec3 up, float yaw, float pitch, vec3 arm)
{
    vec3 side, axis = {up[0], up[1], up[2]};
    glm_vec3_rotate(arm, yaw, axis);
    glm_vec3_cross(arm, axis, side);
    float angle = glm_vec3_angle(arm, axis), margin = (float)(GLM_PI / 180);
    pitch = fmaxf(fminf(pitch, angle - margin), angle - (float)GLM_PI + margin);
    if (glm_vec3_norm(side) > 0) glm_vec3_rotate(arm, pitch, side);
}

void al_eye_orbit(al_eye *eye, float yaw, float pitch)
{
    vec3 arm;
    glm_vec3_sub(eye->position, eye->target, arm);
    turn(eye->up, yaw, pitch, arm);
    glm_vec3_add(eye->target, arm, eye->position);
}

void al_eye_look(al_eye *eye, float yaw, float pitch)
{
    vec3 arm;
    glm_vec3_sub(eye->target, eye->position, arm);
    turn(eye->up, yaw, pitch, arm);
    glm_vec3_add(eye->position, arm, eye->target);
}

void al_eye_move(al_eye *eye, float right, float up, float forward)
{
    vec3 ahead, side, step = {0, 0, 0};
    glm_vec3_sub(eye->target, eye->position, ahead);
    glm_vec3_normalize(ahead);
    glm_vec3_crossn(ahead, eye->up, side);
    glm_vec3_muladds(side, right, step);
    glm_vec3_muladds(eye->up, up, step);
    glm_vec3_muladds(ahead, forward, step);
    glm_vec3_add(eye->position, step, eye->position);
    glm_vec3_add(eye->target, step, eye->target);
}

void al_eye_zoom(al_eye *eye, float factor)
{
    glm_vec3_lerp(eye->target, eye->position, factor, eye->position);
}

void al_jitter(unsigned index, unsigned count, float offset[2])
{
    static const double golden = 0.61803398874989485;
    double from_middle = index + 0.5 - 0.5 * count, turns = from_middle * golden;
    offset[0] = (float)(from_middle / count);
    offset[1] = (float)(turns - round(turns));
}

/* Distances along the view from the nearest to the farthest point of the box; the near plane keeps a ratio of
 * 1e-4 to the far one at least, which a float depth buffer bears well. */
static void planes(const al_eye *eye, const al_bounds *bounds, float *near, float *far)
{
    float farthest = 0, outside = 0;
    vec3 forward;
    glm_vec3_sub((float *)eye->target, (float *)eye->position, forward);
    for (int i = 0; i < 3 && !is_empty(bounds); i++) {
        float below = bounds->low[i] - eye->position[i], above = eye->position[i] - bounds->high[i];
        float gap = fmaxf(0, fmaxf(below, above)), reach = fmaxf(fabsf(below), fabsf(above));
        outside += gap * gap;
        farthest += reach * reach;
    }
    *far = farthest > 0 ? 1.01f * sqrtf(farthest) : fmaxf(2 * glm_vec3_norm(forward), 1e-6f);
    /* The nearest point of the box lies `outside` away; at the corner of the picture that is less along the
     * view. */
    float depth = sqrtf(outside) * cosf(fminf(eye->fov_y_radians, 1.5f));
    *near = fmaxf(0.5f * depth, 1e-4f * *far);
}

al_view al_eye_view(const al_eye *eye, const al_bounds *bounds, const float offset[2], uint32_t width,
                    uint32_t height)
{
    al_view view = {.width = width, .height = height};
    mat4 matrix;
    vec3 forward, up, position, target;
    glm_vec3_copy((float *)eye->position, position);
    glm_vec3_copy((float *)eye->target, target);
    glm_vec3_sub(target, position, forward);
    if (!(glm_vec3_norm(forward) > 0)) forward[2] = -1, target[2] = position[2] - 1;
    sane_up(forward, eye->up, up);
    glm_lookat(position, target, up, matrix);
    memcpy(view.view, matrix, sizeof view.view);

    float near, far;
    planes(eye, bounds, &near, &far);
    glm_perspective(eye->fov_y_radians, (float)width / (float)height, near, far, matrix);
    matrix[2][0] += 2 * offset[0] / (float)width;
    matrix[2][1] += 2 * offset[1] / (float)height;
    memcpy(view.projection, matrix, sizeof view.projection);
    return view;
}
