/* The player's camera: orbits about its target, flies, and makes the matrices of a view. */
#ifndef AIRLIGHT_EYE_H
#define AIRLIGHT_EYE_H

#include "airlight/runtime.h"

typedef struct al_eye { /* metres, world */
    float position[3], target[3];
    float up[3]; /* unit; the axis that orbiting turns about */
    float fov_y_radians;
} al_eye;

typedef struct al_bounds {
    float low[3], high[3]; /* low > high: nothing there */
} al_bounds;

/* World box of everything that is drawn. */
al_bounds al_bounds_of_scene(const al_scene *scene);

al_eye al_eye_from_camera(const al_camera *camera);
/* Stands back until the box fills the picture, looking the way it looks now. */
void al_eye_frame(al_eye *eye, const al_bounds *bounds);

/* Turns the eye about its target, radians. Never over the pole. */
void al_eye_orbit(al_eye *eye, float yaw, float pitch);
/* Turns the target about the eye. */
void al_eye_look(al_eye *eye, float yaw, float pitch);
/* Moves both along right, up and forward, metres. */
void al_eye_move(al_eye *eye, float right, float up, float forward);
/* Multiplies the distance to the target. */
void al_eye_zoom(al_eye *eye, float factor);

/* Subpixel offset of frame `index` of `count`, in pixels within [-0.5, 0.5]: a lattice by the golden ratio, even for every count
 * and its own mirror image about the pixel's centre, so that the frames' mean shifts nothing. One frame: the centre. */
void al_jitter(unsigned index, unsigned count, float offset[2]);

/* Near and far planes enclose the bounds as seen from the eye. */
al_view al_eye_view(const al_eye *eye, const al_bounds *bounds, const float offset[2], uint32_t width,
                    uint32_t height);

#endif
