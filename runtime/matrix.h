/* 4x4 matrices, column-major, in double precision. `out` may be an input. */
#ifndef AIRLIGHT_RUNTIME_MATRIX_H
#define AIRLIGHT_RUNTIME_MATRIX_H

#include <stdbool.h>

void al_matrix_from_float(const float *m, double *out);
void al_matrix_to_float(const double *m, float *out);
void al_matrix_multiply(const double *a, const double *b, double *out);
void al_matrix_transform(const double *m, const double *v, double *out); /* v, out: [4] */
/* false when singular: `out` is then the identity. */
bool al_matrix_inverse(const double *m, double *out);
/* A rotation and a translation, within `tolerance` of orthonormal and right-handed. */
bool al_matrix_is_rigid(const float *m, double tolerance);

#endif
