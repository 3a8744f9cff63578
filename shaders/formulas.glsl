// The formulas that host and device share, in GLSL's words.
#ifndef AL_GLSL
#define AL_GLSL
#define AL_FORMULA
#define AL_REAL float
#define AL_OUT(count, name) out float name[count]
#include "../formats/include/airlight/formulas.h"
#endif
