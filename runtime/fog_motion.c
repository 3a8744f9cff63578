/* Fogs that move as a whole: where a frame's entry is once its fog has been moved from its place. */
#include <math.h>
#include <string.h>

#include "matrix.h"
#include "state.h"

static bool is_still(const float m[16])
{
    for (int i = 0; i < 16; i++)
        if (m[i] != (i % 5 == 0)) return false;
    return true;
}

/* The box around the moved box: exact where it only moves; where it turns, the grid's own box, which turns with its
 * index space, says where the fog ends (docs/scene.md refuses other fogs that turn). */
static void move_bounds(const double m[16], al_fog_entry *entry)
{
    double low[3] = {INFINITY, INFINITY, INFINITY}, high[3] = {-INFINITY, -INFINITY, -INFINITY};
    for (int corner = 0; corner < 8; corner++) {
        double place[4] = {0, 0, 0, 1}, moved[4];
        for (int k = 0; k < 3; k++) place[k] = entry->low[k] + (corner >> k & 1 ? entry->extent[k] : 0);
        al_matrix_transform(m, place, moved);
        for (int k = 0; k < 3; k++) {
            low[k] = fmin(low[k], moved[k]);
            high[k] = fmax(high[k], moved[k]);
        }
    }
    for (int k = 0; k < 3; k++) {
        entry->low[k] = (float)low[k];
        entry->extent[k] = (float)(high[k] - low[k]);
    }
}

void al_fog_move(const al_fog *fog, al_fog_entry *entry)
{
    double moved[16], back[16], to_index[16];
    if (is_still(fog->moved)) return;
    al_matrix_from_float(fog->moved, moved);
    if (!al_matrix_inverse(moved, back)) return;
    if (entry->low[3] > 0) move_bounds(moved, entry);
    al_matrix_from_float(entry->to_index, to_index);
    al_matrix_multiply(to_index, back, to_index);
    al_matrix_to_float(to_index, entry->to_index);
}
