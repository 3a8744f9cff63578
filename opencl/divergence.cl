/* Step 4: divergence of the first moment, rho = |div T|: central differences between interior voxels,
 * one-sided beside the boundary, never across it; 0 where a voxel has no interior neighbour on an axis. */

static inline float al_slope(global const float *t, global const uchar *inside, long at, long step, float voxel)
{
    bool low = inside[at - step] != 0, high = inside[at + step] != 0;
    if (low && high) return (t[at + step] - t[at - step]) / (2.0f * voxel);
    if (high) return (t[at + step] - t[at]) / voxel;
    if (low) return (t[at] - t[at - step]) / voxel;
    return 0.0f;
}

/* Global size: (x, y, z) voxels. moment: three planes [3][z][y][x]; inside: 1 in the interior, and 0 in the
 * outermost layer of the grid, so that neighbours always exist. rho in 1/m. */
kernel void divergence(global const float *moment, global const uchar *inside, int4 size, float voxel,
                       global float *rho)
{
    int x = get_global_id(0), y = get_global_id(1), z = get_global_id(2);
    long row = size.x, slice = row * size.y, count = slice * size.z;
    long at = z * slice + y * row + x;
    if (!inside[at]) {
        rho[at] = 0.0f;
        return;
    }
    rho[at] = fabs(al_slope(moment, inside, at, 1, voxel) + al_slope(moment + count, inside, at, row, voxel) +
                   al_slope(moment + 2 * count, inside, at, slice, voxel));
}
