#include "loader.h"

#include <pthread.h>
#include <stdlib.h>
#include <string.h>

enum { QUEUE_LIMIT = 8 };

typedef struct asset {
    char *path;
    al_kind kind;
    uint32_t index; /* among the scene's assets of its kind */
    al_file *file;
    al_translucent_info info;
    al_medium_info medium;
    al_medium_depth depth;
    al_medium_frame frame; /* the one whose pages are read */
    uint32_t frame_index;
    float *times_s;
    uint32_t *brick_counts;
    al_lightmap_info lightmap;
    al_lightmap_instance *instances;
    uint32_t next_page, page_count;
    bool open; /* pages are still to come */
    bool asked; /* for the frame `request`; under the lock */
    uint32_t request;
} asset;

struct al_loader {
    asset *assets;
    uint32_t asset_count;
    pthread_t thread;
    bool started;
    pthread_mutex_t lock; /* over what follows */
    pthread_cond_t room, work;
    al_arrival queue[QUEUE_LIMIT];
    uint32_t head, count;
    bool stop;
    al_arrival scratch; /* the thread's own */
};

/* Waits for room; false when the loader is to stop. */
static bool push(al_loader *loader, const al_arrival *arrival)
{
    pthread_mutex_lock(&loader->lock);
    while (loader->count == QUEUE_LIMIT && !loader->stop) pthread_cond_wait(&loader->room, &loader->lock);
    bool go_on = !loader->stop;
    if (go_on) loader->queue[(loader->head + loader->count++) % QUEUE_LIMIT] = *arrival;
    pthread_mutex_unlock(&loader->lock);
    return go_on;
}

bool al_loader_take(al_loader *loader, al_arrival *arrival)
{
    pthread_mutex_lock(&loader->lock);
    bool any = loader->count > 0;
    if (any) {
        *arrival = loader->queue[loader->head];
        loader->head = (loader->head + 1) % QUEUE_LIMIT;
        loader->count--;
        pthread_cond_signal(&loader->room);
    }
    pthread_mutex_unlock(&loader->lock);
    return any;
}

static void open_object(asset *a, al_arrival *arrival)
{
    al_status status = al_translucent_read(a->file, &a->info, &arrival->error);
    if (!status)
        status = al_translucent_read_grid(a->file, &a->info, &arrival->density, &arrival->blockers,
                                          &arrival->error);
    arrival->info = a->info;
    arrival->kind = status ? AL_ARRIVAL_FAILURE : AL_ARRIVAL_OBJECT;
    a->page_count = status ? 0 : al_translucent_page_count(&a->info);
}

/* Begins with a frame: what follows are its pages. */
static void open_frame(asset *a, uint32_t index, al_arrival_kind kind, al_arrival *arrival)
{
    al_status status = al_medium_read_frame(a->file, &a->medium, index, &a->frame, &arrival->error);
    if (!status && a->depth.size[0])
        status = al_medium_read_depths(a->file, &a->depth, index, &arrival->depths, &arrival->error);
    a->frame_index = arrival->frame_index = index;
    arrival->frame = a->frame;
    arrival->kind = status ? AL_ARRIVAL_FAILURE : kind;
    a->next_page = 0;
    a->page_count = status ? 0 : al_medium_page_count(&a->medium, &a->frame);
    a->open = a->page_count > 0;
}

static void open_medium(asset *a, al_arrival *arrival)
{
    al_status status = al_medium_read(a->file, &a->medium, &arrival->error);
    if (!status) {
        a->times_s = calloc(a->medium.frame_count, sizeof *a->times_s);
        a->brick_counts = calloc(a->medium.frame_count, sizeof *a->brick_counts);
        if (!a->times_s || !a->brick_counts)
            status = al_fail(&arrival->error, AL_IO, "%s: no memory for its frames", a->path);
    }
    if (!status) status = al_medium_read_times(a->file, &a->medium, a->times_s, a->brick_counts, &arrival->error);
    if (!status) status = al_medium_read_sky(a->file, &arrival->sky, &arrival->error);
    if (!status) status = al_medium_read_depth(a->file, &a->medium, &a->depth, &arrival->error);
    arrival->depth = a->depth;
    arrival->kind = AL_ARRIVAL_FAILURE;
    if (status) return;
    open_frame(a, 0, AL_ARRIVAL_MEDIUM, arrival);
    arrival->medium = a->medium;
    arrival->times_s = a->times_s;
    for (uint32_t i = 0; i < a->medium.frame_count; i++)
        if (a->brick_counts[i] > arrival->brick_limit) arrival->brick_limit = a->brick_counts[i];
}

static void open_lightmap(asset *a, al_arrival *arrival)
{
    al_status status = al_lightmap_read(a->file, &a->lightmap, &arrival->error);
    if (!status) a->instances = calloc(a->lightmap.instance_count + (size_t)1, sizeof *a->instances);
    if (!status && !a->instances)
        status = al_fail(&arrival->error, AL_IO, "%s: no memory for its instances", a->path);
    if (!status) status = al_lightmap_read_instances(a->file, &a->lightmap, a->instances, &arrival->error);
    arrival->lightmap = a->lightmap;
    arrival->instances = a->instances;
    arrival->kind = status ? AL_ARRIVAL_FAILURE : AL_ARRIVAL_LIGHTMAP;
    a->page_count = status ? 0 : a->lightmap.page_count;
}

static void open_probes(asset *a, al_arrival *arrival)
{
    bool failed = al_probes_read(a->file, &arrival->probes, &arrival->error) != AL_OK;
    arrival->kind = failed ? AL_ARRIVAL_FAILURE : AL_ARRIVAL_PROBES;
}

static void open_asset(asset *a, al_arrival *arrival)
{
    al_open_options options = {.kind = a->kind};
    if (al_file_open(a->path, &options, &a->file, &arrival->error))
        arrival->kind = AL_ARRIVAL_FAILURE;
    else if (a->kind == AL_KIND_MEDIUM)
        open_medium(a, arrival);
    else if (a->kind == AL_KIND_LIGHTMAP)
        open_lightmap(a, arrival);
    else if (a->kind == AL_KIND_PROBES)
        open_probes(a, arrival);
    else
        open_object(a, arrival);
    a->open = a->page_count > 0;
}

static void read_page(asset *a, al_arrival *arrival)
{
    uint32_t page = a->next_page++;
    al_status status;
    if (a->kind == AL_KIND_MEDIUM) {
        arrival->kind = AL_ARRIVAL_BRICKS;
        status = al_medium_read_page(a->file, &a->medium, a->frame_index, page, &arrival->bricks, &arrival->error);
    } else if (a->kind == AL_KIND_LIGHTMAP) {
        arrival->kind = AL_ARRIVAL_TEXELS;
        arrival->texels_index = page;
        status = al_lightmap_read_page(a->file, &a->lightmap, page, &arrival->texels, &arrival->error);
    } else {
        arrival->kind = AL_ARRIVAL_PAGE;
        status = al_translucent_read_page(a->file, &a->info, page, &arrival->page, &arrival->error);
    }
    if (status) arrival->kind = AL_ARRIVAL_FAILURE;
    a->open = !status && a->next_page < a->page_count;
}

static void begin_arrival(const asset *a, al_arrival *arrival)
{
    memset(arrival, 0, sizeof *arrival);
    arrival->asset = a->kind;
    arrival->object = a->index;
}

/* Pages of all open assets in turn, so that all of them show early; false: stop. */
static bool hand_out_pages(al_loader *loader)
{
    al_arrival *arrival = &loader->scratch;
    bool any = true;
    while (any) {
        any = false;
        for (uint32_t i = 0; i < loader->asset_count; i++) {
            if (!loader->assets[i].open) continue;
            begin_arrival(&loader->assets[i], arrival);
            read_page(&loader->assets[i], arrival);
            if (!push(loader, arrival)) return false;
            any = true;
        }
    }
    return true;
}

/* Waits until a frame is asked for; NULL: stop. */
static asset *next_request(al_loader *loader)
{
    asset *found = NULL;
    pthread_mutex_lock(&loader->lock);
    while (!found && !loader->stop) {
        for (uint32_t i = 0; i < loader->asset_count && !found; i++)
            if (loader->assets[i].asked) found = &loader->assets[i];
        if (!found) pthread_cond_wait(&loader->work, &loader->lock);
    }
    if (found) found->asked = false;
    pthread_mutex_unlock(&loader->lock);
    return found;
}

void al_loader_request(al_loader *loader, uint32_t fog, uint32_t frame)
{
    pthread_mutex_lock(&loader->lock);
    for (uint32_t i = 0; i < loader->asset_count; i++) {
        asset *a = &loader->assets[i];
        if (a->kind != AL_KIND_MEDIUM || a->index != fog) continue;
        a->request = frame;
        a->asked = true;
    }
    pthread_cond_signal(&loader->work);
    pthread_mutex_unlock(&loader->lock);
}

/* First every asset, then their pages, then the frames that are asked for. */
static void *run(void *user)
{
    al_loader *loader = user;
    bool go_on = true;
    al_arrival *arrival = &loader->scratch;
    for (uint32_t i = 0; i < loader->asset_count && go_on; i++) {
        begin_arrival(&loader->assets[i], arrival);
        open_asset(&loader->assets[i], arrival);
        go_on = push(loader, arrival);
    }
    go_on = go_on && hand_out_pages(loader);
    memset(arrival, 0, sizeof *arrival);
    arrival->kind = AL_ARRIVAL_END;
    go_on = go_on && push(loader, arrival);
    for (asset *a; go_on && (a = next_request(loader)) != NULL;) {
        begin_arrival(a, arrival);
        open_frame(a, a->request, AL_ARRIVAL_FRAME, arrival);
        go_on = push(loader, arrival) && hand_out_pages(loader);
    }
    return NULL;
}

static char *join(const char *folder, const char *name)
{
    size_t head = strlen(folder), tail = strlen(name);
    char *path = malloc(head + tail + 2);
    if (!path) return NULL;
    memcpy(path, folder, head);
    path[head] = '/';
    memcpy(path + head + 1, name, tail + 1);
    return path;
}

static bool add_asset(al_loader *loader, const char *folder, const char *name, al_kind kind, uint32_t index)
{
    asset *a = &loader->assets[loader->asset_count++];
    *a = (asset){.path = join(folder, name), .kind = kind, .index = index};
    return a->path != NULL;
}

al_status al_loader_create(const char *folder, const al_scene *scene, al_loader **loader, al_error *error)
{
    al_loader *made = calloc(1, sizeof *made);
    *loader = NULL;
    if (!made) return al_fail(error, AL_IO, "%s: no memory for the loader", folder);
    pthread_mutex_init(&made->lock, NULL);
    pthread_cond_init(&made->room, NULL);
    pthread_cond_init(&made->work, NULL);
    made->assets = calloc((size_t)scene->translucent_count + scene->fog_count + 3, sizeof *made->assets);
    bool good = made->assets != NULL;
    for (uint32_t i = 0; i < scene->translucent_count && good; i++)
        good = add_asset(made, folder, scene->translucents[i].asset, AL_KIND_TRANSLUCENT, i);
    for (uint32_t i = 0; i < scene->fog_count && good; i++)
        if (*scene->fogs[i].asset) good = add_asset(made, folder, scene->fogs[i].asset, AL_KIND_MEDIUM, i);
    if (good && *scene->baked.lightmap)
        good = add_asset(made, folder, scene->baked.lightmap, AL_KIND_LIGHTMAP, 0);
    if (good && *scene->baked.probes) good = add_asset(made, folder, scene->baked.probes, AL_KIND_PROBES, 0);
    if (good) made->started = pthread_create(&made->thread, NULL, run, made) == 0;
    if (!made->started) {
        al_loader_free(made);
        return al_fail(error, AL_IO, "%s: cannot start the loader thread", folder);
    }
    *loader = made;
    return AL_OK;
}

void al_loader_free(al_loader *loader)
{
    if (!loader) return;
    if (loader->started) {
        pthread_mutex_lock(&loader->lock);
        loader->stop = true;
        pthread_cond_signal(&loader->room);
        pthread_cond_signal(&loader->work);
        pthread_mutex_unlock(&loader->lock);
        pthread_join(loader->thread, NULL);
    }
    for (uint32_t i = 0; i < loader->asset_count; i++) {
        if (loader->assets[i].file) al_file_close(loader->assets[i].file);
        free(loader->assets[i].path);
        free(loader->assets[i].instances);
        free(loader->assets[i].times_s);
        free(loader->assets[i].brick_counts);
    }
    free(loader->assets);
    pthread_cond_destroy(&loader->room);
    pthread_cond_destroy(&loader->work);
    pthread_mutex_destroy(&loader->lock);
    free(loader);
}
