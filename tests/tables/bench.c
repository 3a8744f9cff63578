/* Nanoseconds of each look-up, for docs/performance.md: airlight-bench-tables TABLES.air. Not a test. */
#define _POSIX_C_SOURCE 200809L
#include <time.h>

#include "tables.h"

enum { COUNT = 200000 };

static double seconds(void) /* of this process: other work on the machine does not count */
{
    struct timespec now;
    clock_gettime(CLOCK_PROCESS_CPUTIME_ID, &now);
    return (double)now.tv_sec + 1e-9 * (double)now.tv_nsec;
}

static double number(int i, double low, double high) /* a different one for each i */
{
    double x = 0.618034 * i;
    return low + (high - low) * (x - floor(x));
}

static void say(const char *what, double started, int count, double sum)
{
    printf("%-44s %7.0f ns%s\n", what, (seconds() - started) / count * 1e9, sum < 0 ? " " : "");
}

int main(int argc, char **argv)
{
    static const char *const names[] = {"point", "directional", "area"};
    char what[128];
    double sum = 0;
    al_error error;
    al_impulse_medium *medium;
    if (argc != 2) return 2;
    al_impulse_tables *tables = tables_open(argv[1]);
    const al_impulse_medium_settings s = {.first_event = 1, .last_event = 10, .albedo = 0.9, .g = 0.3};
    double started = seconds();
    if (al_impulse_medium_make(tables, &s, &medium, &error) != AL_OK) return 1;
    printf("%-44s %7.1f ms\n", "collapse a medium", (seconds() - started) * 1e3);
    for (int e = 0; e < 3; e++) {
        started = seconds();
        for (int i = 0; i < COUNT; i++)
            sum += al_impulse_medium_irradiance(medium, (al_impulse_emitter)e, number(i, 0.01, 5), number(3 * i, -1, 1),
                                                0.7, number(5 * i, -1, 1), 0);
        snprintf(what, sizeof what, "irradiance in a medium, all events, %s", names[e]);
        say(what, started, COUNT, sum);
        for (int all = 0; all < 2; all++) {
            al_impulse_answer a;
            al_impulse_query q = canonical((al_impulse_emitter)e, 1, 1, all ? 10 : 1);
            q.sigma_a_per_m = 0.1;
            started = seconds();
            for (int i = 0; i < COUNT / 10; i++) {
                q.distance_m = number(i, 0.01, 5);
                q.cos_normal = number(3 * i, -1, 1);
                al_impulse_response(tables, &q, &a);
                sum += a.sh[0][0];
            }
            snprintf(what, sizeof what, "response, %s, %s", all ? "10 events" : "event 1, isotropic", names[e]);
            say(what, started, COUNT / 10, sum);
        }
    }
    for (int e = 0; e < 3; e++) {
        al_impulse_ray ray = {.emitter = (al_impulse_emitter)e, .cos_normal = 0.5, .length_m = 2, .sigma_s_per_m = 0.5};
        started = seconds();
        for (int i = 0; i < COUNT; i++) {
            ray.distance_m = number(i, 0.01, 5);
            ray.direction_z = number(7 * i, -1, 1);
            ray.direction_x = sqrt(1 - ray.direction_z * ray.direction_z);
            sum += al_impulse_airlight(&ray);
        }
        snprintf(what, sizeof what, "airlight along a ray, %s", names[e]);
        say(what, started, COUNT, sum);
    }
    al_impulse_medium_free(medium);
    al_impulse_tables_free(tables);
    return 0;
}
