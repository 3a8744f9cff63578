/* What the OpenGL driver has to say, for --verbose. */
#ifndef AIRLIGHT_DEBUG_OUTPUT_H
#define AIRLIGHT_DEBUG_OUTPUT_H

/* Prints the driver's messages (not its notifications) on standard error; the context must be current. */
void al_debug_output_begin(void);

#endif
