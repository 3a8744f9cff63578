#define _POSIX_C_SOURCE 200809L
#include <math.h>
#include <stdio.h>
#include <stdlib.h>

#include "airlight/container.h"
#include "results.h"

al_status al_results_csv(const al_trade *trade, al_error *error)
{
    char path[PATH_MAX], *text = NULL;
    size_t size = 0;
    snprintf(path, sizeof path, "%s/trade.csv", trade->folder);
    FILE *out = open_memstream(&text, &size);
    if (!out) return al_fail(error, AL_IO, "%s: out of memory", path);
    for (int k = 0; k < trade->knobs.count; k++) fprintf(out, "%s,", trade->knobs.knobs[k].name);
    fprintf(out, "relative_rmse,flip_ldr,seconds,frame_ms,memory_bytes,asset_bytes,front,held_out_relative_rmse,preset\n");
    for (int i = 0; i < trade->points.count; i++) {
        const al_point *p = &trade->points.points[i];
        if (p->left_out) continue;
        for (int k = 0; k < trade->knobs.count; k++) fprintf(out, "%s,", trade->knobs.knobs[k].values[p->chosen[k]]);
        fprintf(out, "%.6g,%.6g,%.6g,%.6g,%.0f,%.0f,%d,", p->relative_rmse, p->flip_ldr, p->seconds, p->frame_ms,
                p->memory_bytes, p->asset_bytes, p->front);
        if (isfinite(p->held_out_relative_rmse)) fprintf(out, "%.6g", p->held_out_relative_rmse);
        fprintf(out, ",%s\n", p->preset);
    }
    al_status status = fclose(out) ? al_fail(error, AL_IO, "%s: out of memory", path) : al_write_file(path, text, size, error);
    free(text);
    return status;
}
