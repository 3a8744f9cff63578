/* Loading OpenVDB and what it needs takes longer than many a whole bake: the bridge is a module, loaded at the first grid. */
#include <dlfcn.h>
#include <stddef.h>

#include "beside.h"
#include "vdb_bridge.h"

al_status al_vdb_read(const char *path, const char *grid_name, uint64_t size_limit, al_vdb_grid *grid, al_error *error)
{
    char module[PATH_MAX];
    al_status status = al_find_beside(AIRLIGHT_VDB_MODULE, module, error);
    if (status) return status;
    void *library = dlopen(module, RTLD_NOW | RTLD_LOCAL);
    al_vdb_reader *read = NULL;
    if (library) *(void **)&read = dlsym(library, "al_vdb_read");
    if (!read) return al_fail(error, AL_IO, "%s: needs OpenVDB: %s; install airlight whole", path, dlerror());
    return read(path, grid_name, size_limit, grid, error); /* stays loaded for the next */
}
