/* Step 4: divergence of the first moment, rho = |div T|. */
#include "sweep.h"

al_status al_divergence(al_device *device, const al_grid *grid, const float *moment, float *rho,
                        al_error *error)
{
    cl_kernel kernel = NULL;
    cl_mem moment_buffer = NULL, inside_buffer = NULL, rho_buffer = NULL;
    size_t count = al_grid_count(grid), size[3] = {grid->size[0], grid->size[1], grid->size[2]};
    cl_int4 shape = {{(cl_int)grid->size[0], (cl_int)grid->size[1], (cl_int)grid->size[2], 0}};
    cl_float voxel = (cl_float)grid->voxel_m;
    al_status status = al_device_kernel(device, "divergence", &kernel, error);
    if (status == AL_OK)
        status = al_device_buffer(device, 3 * count * sizeof *moment, moment, &moment_buffer, error);
    if (status == AL_OK) status = al_device_buffer(device, count, grid->inside, &inside_buffer, error);
    if (status == AL_OK) status = al_device_buffer(device, count * sizeof *rho, NULL, &rho_buffer, error);
    if (status == AL_OK) {
        al_argument arguments[] = {AL_ARGUMENT(moment_buffer), AL_ARGUMENT(inside_buffer), AL_ARGUMENT(shape),
                                   AL_ARGUMENT(voxel), AL_ARGUMENT(rho_buffer)};
        status = al_device_run(device, kernel, size, arguments, sizeof arguments / sizeof *arguments, error);
    }
    if (status == AL_OK) status = al_device_read(device, rho_buffer, rho, count * sizeof *rho, error);
    al_device_release(&moment_buffer);
    al_device_release(&inside_buffer);
    al_device_release(&rho_buffer);
    if (kernel) clReleaseKernel(kernel);
    return status;
}
