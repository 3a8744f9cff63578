#include "airlight/sh.h"

#include <math.h>

#include "airlight/formulas.h"

void al_sh_basis_f(int order, const float direction[3], float *basis)
{
    double values[AL_SH_MAX_COUNT];
    al_sh_basis(order, direction[0], direction[1], direction[2], values);
    for (int i = 0; i < order * order; i++) basis[i] = (float)values[i];
}

void al_sh_phase(int order, float g, const float axis[3], float *out)
{
    double values[AL_SH_MAX_COUNT], moment = 1;
    al_sh_basis(order, axis[0], axis[1], axis[2], values);
    for (int l = 0; l < order; l++, moment *= g)
        for (int i = l * l; i < (l + 1) * (l + 1); i++) out[i] = (float)(moment * values[i]);
}

void al_direction_set(uint32_t count, uint32_t index, double direction[3])
{
    uint32_t half = count / 2, i = index % half;
    double sign = index < half ? 1 : -1;
    double golden_angle = AL_PI * (3 - sqrt(5.0));
    double z = 1 - (2.0 * i + 1) / half, radius = sqrt(fmax(0, 1 - z * z)), angle = golden_angle * i;
    direction[0] = sign * radius * cos(angle);
    direction[1] = sign * radius * sin(angle);
    direction[2] = sign * z;
}
