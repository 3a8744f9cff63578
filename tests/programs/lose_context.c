/* Preloaded into the player: a driver that loses the context. From when the file AIRLIGHT_LOST_FILE exists on,
 * glGetGraphicsResetStatus is asked AIRLIGHT_LOST_CALLS (0) more times in vain, and then answers that the device was
 * reset. Takes the place of libepoxy's pointer to that function, which programs call through. */
#include <stdlib.h>
#include <unistd.h>

enum { NO_ERROR = 0, GUILTY_CONTEXT_RESET = 0x8253 }; /* OpenGL 4.5, table 2.2 and section 2.3.2 */

static unsigned answer(void)
{
    static long calls;
    const char *file = getenv("AIRLIGHT_LOST_FILE"), *limit = getenv("AIRLIGHT_LOST_CALLS");
    if (!file || access(file, F_OK) != 0) return NO_ERROR;
    return calls++ < (limit ? atol(limit) : 0) ? NO_ERROR : GUILTY_CONTEXT_RESET;
}

unsigned (*epoxy_glGetGraphicsResetStatus)(void) = answer;
