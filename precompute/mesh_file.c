#include "mesh_file.h"

#include <assimp/cfileio.h>
#include <assimp/cimport.h>
#include <assimp/postprocess.h>
#include <assimp/scene.h>
#include <math.h>
#include <stdio.h>
#include <stdlib.h>
#include <string.h>
#include <strings.h>

#include "geometry.h"
#include "gltf_extras.h"
#include "gltf_motion.h"
#include "inputs.h"
#include "material_file.h"
#include "motion_import.h"
#include "off_file.h"

enum { NODE_DEPTH_LIMIT = 512 };

/* --- files for assimp: read whole, hashed as read --- */

typedef struct file_source {
    al_import *import;
    const char *path; /* of the mesh file, and what is read in its place, unless NULL */
    const uint8_t *instead;
    size_t instead_size;
    al_error failure; /* of a file that is there but cannot be read */
} file_source;

typedef struct open_file {
    uint8_t *bytes;
    size_t size, at;
} open_file;

static size_t file_read(struct aiFile *file, char *out, size_t size, size_t count)
{
    open_file *from = (open_file *)(void *)file->UserData;
    if (!size) return 0;
    size_t whole = (from->size - from->at) / size;
    if (count > whole) count = whole;
    memcpy(out, from->bytes + from->at, size * count);
    from->at += size * count;
    return count;
}

static size_t file_write(struct aiFile *file, const char *data, size_t size, size_t count)
{
    (void)file, (void)data, (void)size, (void)count;
    return 0;
}

static size_t file_tell(struct aiFile *file)
{
    return ((open_file *)(void *)file->UserData)->at;
}

static size_t file_size(struct aiFile *file)
{
    return ((open_file *)(void *)file->UserData)->size;
}

static aiReturn file_seek(struct aiFile *file, size_t offset, enum aiOrigin origin)
{
    open_file *from = (open_file *)(void *)file->UserData;
    size_t base = origin == aiOrigin_SET ? 0 : origin == aiOrigin_CUR ? from->at : from->size;
    if (base + offset > from->size) return aiReturn_FAILURE; /* wraps for steps back, as it should */
    from->at = base + offset;
    return aiReturn_SUCCESS;
}

static void file_flush(struct aiFile *file)
{
    (void)file;
}

static void file_close(struct aiFileIO *io, struct aiFile *file)
{
    (void)io;
    if (!file) return;
    free(((open_file *)(void *)file->UserData)->bytes);
    free(file->UserData);
    free(file);
}

/* assimp takes a line end that happens to begin a PLY file's binary data for one of the header: it is given one
 * more to take. There is room: zeros follow the bytes. */
static void double_line_end(open_file *file)
{
    static const char end[] = "end_header\n";
    if (file->size < 4 || memcmp(file->bytes, "ply", 3)) return;
    const char *header = (const char *)file->bytes, *last = strstr(header, end); /* zeros end the bytes */
    if (!last || !strstr(header, "format binary") || strstr(header, "format binary") > last) return;
    size_t data = (size_t)(last - header) + sizeof end - 1;
    if (data >= file->size || file->bytes[data] != '\n') return;
    memmove(file->bytes + data + 1, file->bytes + data, file->size - data);
    file->size++;
}

static bool open_bytes(file_source *source, const char *path, open_file *opened)
{
    if (!source->instead || strcmp(path, source->path))
        return al_inputs_read(source->import, path, &opened->bytes, &opened->size, &source->failure) == AL_OK;
    opened->size = source->instead_size;
    opened->bytes = calloc(opened->size + 16, 1);
    if (opened->bytes) memcpy(opened->bytes, source->instead, opened->size);
    return opened->bytes != NULL;
}

static struct aiFile *file_open(struct aiFileIO *io, const char *path, const char *mode)
{
    file_source *source = (file_source *)(void *)io->UserData;
    if (strchr(mode, 'w')) return NULL;
    open_file *opened = calloc(1, sizeof *opened);
    struct aiFile *file = calloc(1, sizeof *file);
    bool good = opened && file && open_bytes(source, path, opened);
    if (!good) {
        free(opened);
        free(file);
        return NULL;
    }
    double_line_end(opened);
    *file =
        (struct aiFile){file_read, file_write, file_tell, file_size, file_seek, file_flush, (char *)opened};
    return file;
}

/* --- one import --- */

typedef struct mesh_import {
    al_import *import;
    const al_mesh_description *mesh;
    const al_mesh_use *use;
    const struct aiScene *file;
    al_mesh_format format;
    double placement[16]; /* file space to world: the scene file's transform and unit */
    al_gltf_extras extras;
    uint32_t entry_node; /* of the scene file's motion of this mesh, or AL_NO_INDEX */
    al_gltf *gltf;       /* NULL: no glTF */
    al_gltf_motion *motion;
    const struct aiNode **gltf_nodes; /* [gltf_node_count] assimp's node for each of the file's */
    uint32_t gltf_node_count;
    uint32_t *materials; /* [file->mNumMaterials] scene material or AL_NO_INDEX */
    al_corners corners;  /* of the mesh being made */
    al_submesh *submeshes;
    uint32_t submesh_count;
} mesh_import;

static al_status out_of_memory(const mesh_import *job, al_error *error)
{
    return al_fail(error, AL_IO, "%s: out of memory", job->use->name);
}

static al_status format_of(const char *path, al_mesh_format *format)
{
    static const struct {
        const char *ending;
        al_mesh_format format;
    } known[] = {{".gltf", AL_MESH_GLTF},
                 {".glb", AL_MESH_GLTF},
                 {".obj", AL_MESH_OBJ},
                 {".ply", AL_MESH_PLAIN},
                 {".stl", AL_MESH_PLAIN}};
    const char *ending = strrchr(path, '.');
    for (size_t i = 0; ending && i < sizeof known / sizeof known[0]; i++)
        if (strcasecmp(ending, known[i].ending) == 0) {
            *format = known[i].format;
            return AL_OK;
        }
    return AL_BAD_INPUT;
}

static al_status load_file(mesh_import *job, al_error *error)
{
    const char *path = job->mesh->file;
    uint8_t *bytes;
    size_t size;
    if (format_of(path, &job->format))
        return al_fail(error, AL_BAD_INPUT,
                       "%s: unknown kind of mesh file; .gltf, .glb, .obj, .ply, .off or .stl is "
                       "right",
                       job->use->name);
    al_status status =
        al_inputs_read(job->import, path, &bytes, &size, error); /* a clear word when it is absent */
    if (status) return status;
    if (!size)
        status = al_fail(error, AL_BAD_INPUT, "%s: the file is empty", job->use->name);
    else if (job->format == AL_MESH_GLTF)
        status = al_gltf_open(job->import, job->use->name, path, bytes, size, &job->gltf, error);
    if (!status && job->gltf)
        status = al_gltf_extras_read(job->use->name, al_gltf_root(job->gltf), &job->extras, error);
    free(bytes);
    bytes = NULL;
    if (!status && job->gltf) status = al_gltf_without_motion(job->gltf, &bytes, &size, error);
    if (status) return status;
    file_source source = {.import = job->import, .path = path, .instead = bytes, .instead_size = size};
    struct aiFileIO io = {file_open, file_close, (char *)&source};
    job->file = aiImportFileEx(path, aiProcess_Triangulate, &io);
    free(bytes);
    if (!job->file) {
        char reason[512];
        snprintf(reason, sizeof reason, "%s", aiGetErrorString());
        for (char *at = reason; *at; at++)
            if ((unsigned char)*at < ' ') *at = ' ';
        return al_fail(error, AL_BAD_INPUT, "%s: cannot be read as a mesh: %s", job->use->name, reason);
    }
    if (job->file->mFlags & AI_SCENE_FLAGS_INCOMPLETE && !job->file->mNumMeshes && !job->file->mNumLights &&
        !job->file->mNumCameras)
        return al_fail(error, AL_BAD_INPUT, "%s: holds no mesh, light or camera", job->use->name);
    job->materials = malloc((job->file->mNumMaterials + (size_t)1) * sizeof *job->materials);
    if (!job->materials) return out_of_memory(job, error);
    for (unsigned i = 0; i < job->file->mNumMaterials; i++) job->materials[i] = AL_NO_INDEX;
    return AL_OK;
}

/* --- nodes --- */

static void node_matrix(const struct aiNode *node, double m[16])
{
    const struct aiMatrix4x4 *t = &node->mTransformation; /* rows a to d */
    const double rows[4][4] = {{t->a1, t->a2, t->a3, t->a4},
                               {t->b1, t->b2, t->b3, t->b4},
                               {t->c1, t->c2, t->c3, t->c4},
                               {t->d1, t->d2, t->d3, t->d4}};
    for (int row = 0; row < 4; row++)
        for (int column = 0; column < 4; column++) m[column * 4 + row] = rows[row][column];
}

/* Object space of `node` to the world. */
static void node_to_world(const mesh_import *job, const struct aiNode *node, double out[16])
{
    double total[16], own[16];
    node_matrix(node, total);
    for (const struct aiNode *at = node->mParent; at; at = at->mParent) {
        node_matrix(at, own);
        al_matrix_multiply(own, total, total);
    }
    al_matrix_multiply(job->placement, total, out);
}

static const struct aiNode *find_node(const struct aiNode *from, const char *name)
{
    if (strcmp(from->mName.data, name) == 0) return from;
    for (unsigned i = 0; i < from->mNumChildren; i++) {
        const struct aiNode *found = find_node(from->mChildren[i], name);
        if (found) return found;
    }
    return NULL;
}

/* --- motion --- */

/* assimp keeps the nodes of glTF as they are, below a node of its own where there are several roots. */
static al_status pair_nodes(mesh_import *job, const struct aiNode *node, uint32_t index, al_error *error)
{
    const json_t *children = json_object_get(al_gltf_element(job->gltf, "nodes", index), "children");
    al_status status = AL_OK;
    if (index >= job->gltf_node_count || node->mNumChildren != json_array_size(children))
        return al_fail(error, AL_BAD_INPUT, "%s: node \"%s\" has %u children here and %zu in the file",
                       job->use->name, node->mName.data, node->mNumChildren, json_array_size(children));
    job->gltf_nodes[index] = node;
    for (unsigned i = 0; i < node->mNumChildren && !status; i++)
        status = pair_nodes(job, node->mChildren[i], (uint32_t)json_integer_value(json_array_get(children, i)), error);
    return status;
}

/* The file's motion; its nodes hang on the one of the scene file's keys, if there are any (motion_import.h). */
static al_status open_motion(mesh_import *job, al_error *error)
{
    const json_t *root = al_gltf_root(job->gltf);
    uint32_t number = al_gltf_index(root, "scene");
    const json_t *scene = al_gltf_element(job->gltf, "scenes", number == AL_NO_INDEX ? 0 : number),
                 *roots = json_object_get(scene, "nodes");
    const struct aiNode *top = job->file->mRootNode;
    size_t count = json_array_size(roots);
    double placement[16];
    al_status status = AL_OK;
    job->gltf_node_count = (uint32_t)json_array_size(json_object_get(root, "nodes"));
    job->gltf_nodes = calloc(job->gltf_node_count + (size_t)1, sizeof(struct aiNode *));
    if (!job->gltf_nodes) return out_of_memory(job, error);
    memcpy(placement, job->placement, sizeof placement);
    for (int i = 0; i < 3 && job->entry_node != AL_NO_INDEX; i++) placement[12 + i] -= job->use->pivot_m[i];
    status = al_gltf_motion_open(job->import, job->gltf, job->use->name, job->mesh->animation, placement,
                                 job->entry_node, &job->motion, error);
    for (unsigned i = 0; i < count && !status; i++) {
        const struct aiNode *node = count == 1 ? top : i < top->mNumChildren ? top->mChildren[i] : NULL;
        if (node) status = pair_nodes(job, node, (uint32_t)json_integer_value(json_array_get(roots, i)), error);
    }
    return status;
}

static uint32_t gltf_node(const mesh_import *job, const struct aiNode *node)
{
    for (uint32_t i = 0; i < job->gltf_node_count; i++)
        if (job->gltf_nodes[i] == node) return i;
    return AL_NO_INDEX;
}

/* Hangs what has the matrix `world` in the scene at rest, and belongs to `node` (NULL: to the whole mesh), on what
 * moves it, if anything does. */
static al_status bind(mesh_import *job, al_motion_kind kind, uint32_t index, const struct aiNode *node,
                      const double world[16], al_error *error)
{
    uint32_t own = node && job->motion ? gltf_node(job, node) : AL_NO_INDEX, to = job->entry_node;
    double at_rest[16], local[16];
    bool moves = own != AL_NO_INDEX && al_gltf_motion_moves(job->motion, own);
    if (!moves && to == AL_NO_INDEX) return AL_OK;
    memcpy(local, world, sizeof local);
    for (int i = 0; i < 3; i++) local[12 + i] -= job->use->pivot_m[i];
    if (moves) {
        al_status status = al_gltf_motion_node(job->motion, own, &to, error);
        if (status) return status;
        node_to_world(job, node, at_rest);
        for (int i = 0; i < 16; i++) local[i] = i % 5 == 0;
        if (fabs(al_matrix_determinant(at_rest)) > 0) {
            al_matrix_invert(at_rest, local);
            al_matrix_multiply(local, world, local);
        }
    }
    return al_motion_bind(job->import, kind, index, to, local, error);
}

static bool is_inside(const struct aiNode *node, const struct aiNode *root)
{
    for (; node; node = node->mParent)
        if (node == root) return true;
    return false;
}

/* --- geometry --- */

static al_status check_finite(const mesh_import *job, const struct aiMesh *mesh, al_error *error)
{
    for (unsigned i = 0; i < mesh->mNumVertices; i++) {
        const struct aiVector3D *v = &mesh->mVertices[i];
        if (!isfinite(v->x) || !isfinite(v->y) || !isfinite(v->z))
            return al_fail(error, AL_BAD_INPUT,
                           "%s: vertex %u of \"%s\" is (%g, %g, %g); finite numbers are right",
                           job->use->name, i, mesh->mName.data, v->x, v->y, v->z);
    }
    return AL_OK;
}

/* assimp counts v upwards; textures here have their first row on top. */
static void copy_corner(const struct aiMesh *mesh, unsigned vertex, al_corners *out)
{
    size_t to = out->count++;
    out->marks[to] = 0;
    const struct aiVector3D *p = &mesh->mVertices[vertex];
    memcpy(out->positions + to * 3, (float[3]){p->x, p->y, p->z}, 3 * sizeof(float));
    float normal[3] = {0};
    if (mesh->mNormals)
        memcpy(normal,
               (float[3]){mesh->mNormals[vertex].x, mesh->mNormals[vertex].y, mesh->mNormals[vertex].z},
               sizeof normal);
    memcpy(out->normals + to * 3, normal, sizeof normal);
    float *uvs[2] = {out->uv0 + to * 2, out->uv1 + to * 2};
    for (int set = 0; set < 2; set++) {
        const struct aiVector3D *uv = mesh->mTextureCoords[set] ? &mesh->mTextureCoords[set][vertex] : NULL;
        uvs[set][0] = uv ? uv->x : 0;
        uvs[set][1] = uv ? 1 - uv->y : 0;
    }
}

static al_status material_of(mesh_import *job, const struct aiMesh *mesh, uint32_t *material, al_error *error)
{
    const al_scene_description *description = job->import->description;
    for (uint32_t i = 0; *job->mesh->material && i < description->material_count; i++)
        if (strcmp(description->materials[i].name, job->mesh->material) == 0) {
            *material = i; /* the scene file's materials come first in the scene */
            return AL_OK;
        }
    if (mesh->mMaterialIndex >= job->file->mNumMaterials)
        return al_material_default(&job->import->scene, material, error);
    uint32_t index = mesh->mMaterialIndex;
    float strength = index < job->extras.material_count ? job->extras.emissive_strength[index] : 1;
    return al_material_import(job->import, job->file, job->format, job->mesh->file, index, strength,
                              job->materials, material, error);
}

static al_status add_submesh(mesh_import *job, uint32_t material, uint32_t first, al_error *error)
{
    uint32_t count = job->corners.count - first;
    if (!count) return AL_OK;
    al_submesh *last = job->submesh_count ? &job->submeshes[job->submesh_count - 1] : NULL;
    if (last && last->material == material) {
        last->index_count += count;
        return AL_OK;
    }
    al_submesh *grown = realloc(job->submeshes, (job->submesh_count + (size_t)1) * sizeof *grown);
    if (!grown) return out_of_memory(job, error);
    job->submeshes = grown;
    grown[job->submesh_count++] = (al_submesh){first, count, material};
    return AL_OK;
}

/* Appends the triangles of one of the file's meshes; points and lines are left out. */
static al_status append_triangles(mesh_import *job, const struct aiMesh *mesh, al_error *error)
{
    uint32_t first = job->corners.count, material;
    if (mesh->mNumFaces > UINT32_MAX / 12)
        return al_fail(error, AL_BAD_INPUT, "%s: has %u triangles; at most %u are right", job->use->name,
                       mesh->mNumFaces, UINT32_MAX / 12);
    al_status status = check_finite(job, mesh, error);
    if (!status) status = al_corners_reserve(&job->corners, mesh->mNumFaces * 3, error);
    if (status) return status;
    for (unsigned i = 0; i < mesh->mNumFaces; i++) {
        const struct aiFace *face = &mesh->mFaces[i];
        for (unsigned k = 0; k < face->mNumIndices; k++)
            if (face->mIndices[k] >= mesh->mNumVertices)
                return al_fail(error, AL_BAD_INPUT, "%s: triangle %u of \"%s\" names vertex %u of %u",
                               job->use->name, i, mesh->mName.data, face->mIndices[k], mesh->mNumVertices);
        for (unsigned k = 0; k < 3 && face->mNumIndices == 3; k++)
            copy_corner(mesh, face->mIndices[k], &job->corners);
    }
    job->corners.has_uv0 = job->corners.has_uv0 || mesh->mTextureCoords[0];
    job->corners.has_uv1 = job->corners.has_uv1 || mesh->mTextureCoords[1];
    status = material_of(job, mesh, &material, error);
    return status ? status : add_submesh(job, material, first, error);
}

/* Turns what has been gathered into a mesh of the scene. */
static al_status finish_mesh(mesh_import *job, const char *name, uint32_t *index, al_error *error)
{
    al_scene *scene = &job->import->scene;
    for (size_t i = 0; i < job->corners.count * (size_t)3; i++)
        if (!isfinite(job->corners.positions[i]))
            return al_fail(error, AL_BAD_INPUT, "%s: its transforms lead beyond all numbers", job->use->name);
    al_status status = al_corners_to_mesh(scene, &job->corners, name, index, error);
    if (!status) {
        al_mesh *mesh = &scene->meshes[*index];
        mesh->submesh_count = job->submesh_count;
        mesh->submeshes = al_scene_array(scene, job->submesh_count, sizeof *mesh->submeshes);
        if (mesh->submeshes)
            memcpy(mesh->submeshes, job->submeshes, job->submesh_count * sizeof *job->submeshes);
        else
            status = out_of_memory(job, error);
    }
    job->corners.count = job->submesh_count = 0;
    job->corners.has_uv0 = job->corners.has_uv1 = false;
    return status;
}

static al_status add_instance(mesh_import *job, const char *name, uint32_t mesh, const double world[16],
                              al_error *error)
{
    al_scene *scene = &job->import->scene;
    al_instance *instance =
        al_scene_append(scene, &scene->instances, &scene->instance_count, sizeof *instance);
    if (!instance) return out_of_memory(job, error);
    *instance = (al_instance){al_scene_text(scene, name), mesh, job->use->role, job->use->translucent, {0},
                              job->mesh->lighting};
    if (!instance->name) return out_of_memory(job, error);
    for (int i = 0; i < 16; i++) {
        instance->world[i] = (float)world[i];
        if (!isfinite(instance->world[i]))
            return al_fail(error, AL_BAD_INPUT, "%s: node \"%s\" has a transform that is not finite",
                           job->use->name, name);
    }
    return AL_OK;
}

/* A shape, OFF file, boundary or blocker is one mesh, gathered in object space. */
static al_status add_whole(mesh_import *job, const double object[16], al_error *error)
{
    uint32_t index;
    if (!job->corners.count) return al_fail(error, AL_BAD_INPUT, "%s: has no triangles", job->use->name);
    al_status status = finish_mesh(job, job->mesh->name, &index, error);
    if (!status) status = add_instance(job, job->mesh->name, index, object, error);
    return status ? status
                  : bind(job, AL_MOTION_INSTANCE, job->import->scene.instance_count - 1, NULL, object, error);
}

static al_status gather_nodes(mesh_import *job, const struct aiNode *node, const double to_object[16],
                              int depth, al_error *error)
{
    double world[16], matrix[16];
    uint32_t first = job->corners.count;
    al_status status = AL_OK;
    if (depth > NODE_DEPTH_LIMIT)
        return al_fail(error, AL_BAD_INPUT, "%s: nodes are nested more than %d deep", job->use->name,
                       NODE_DEPTH_LIMIT);
    for (unsigned i = 0; i < node->mNumMeshes && !status; i++)
        status = append_triangles(job, job->file->mMeshes[node->mMeshes[i]], error);
    node_to_world(job, node, world);
    al_matrix_multiply(to_object, world, matrix);
    al_corners_transform(&job->corners, first, matrix);
    for (unsigned i = 0; i < node->mNumChildren && !status; i++)
        status = gather_nodes(job, node->mChildren[i], to_object, depth + 1, error);
    return status;
}

/* A mesh with a skin or morph targets keeps the file's vertices apart, in its own space; with a skin its joints
 * bring it into the world, its own node does not count (glTF 2.0, section 3.7.3). */
static al_status add_deformed(mesh_import *job, const struct aiNode *node, uint32_t own, al_error *error)
{
    double world[16];
    uint32_t index, instance;
    al_status status = AL_OK;
    for (unsigned i = 0; i < node->mNumMeshes && !status; i++) {
        uint32_t first = job->corners.count, material;
        status = al_gltf_motion_corners(job->motion, own, i, &job->corners, error);
        if (!status) status = material_of(job, job->file->mMeshes[node->mMeshes[i]], &material, error);
        if (!status) status = add_submesh(job, material, first, error);
    }
    if (status || !job->corners.count) return status;
    status = finish_mesh(job, node->mName.data, &index, error);
    for (int i = 0; i < 16; i++) world[i] = i % 5 == 0;
    if (!al_gltf_motion_skinned(job->motion, own)) node_to_world(job, node, world);
    if (!status) status = add_instance(job, node->mName.data, index, world, error);
    instance = job->import->scene.instance_count - 1;
    if (!status && !al_gltf_motion_skinned(job->motion, own))
        status = bind(job, AL_MOTION_INSTANCE, instance, node, world, error);
    return status ? status : al_gltf_motion_deform(job->motion, own, &job->corners, instance, error);
}

/* Even transforms stay in the instance, so that nodes can share a mesh; others go into the vertices. What is
 * scaled to nothing is left out, unless it may grow. */
static al_status add_node(mesh_import *job, const struct aiNode *node, uint32_t *shared, al_error *error)
{
    double world[16], rigid[16], rest[16];
    uint32_t index = AL_NO_INDEX;
    al_status status = AL_OK;
    uint32_t own = job->motion ? gltf_node(job, node) : AL_NO_INDEX;
    if (own != AL_NO_INDEX && al_gltf_motion_deforms(job->motion, own)) return add_deformed(job, node, own, error);
    node_to_world(job, node, world);
    bool flat = !(fabs(al_matrix_determinant(world)) > 0);
    if (flat && !(own != AL_NO_INDEX && al_gltf_motion_moves(job->motion, own))) return AL_OK;
    bool even = flat || al_matrix_split(world, rigid, rest);
    if (even && node->mNumMeshes == 1) index = shared[node->mMeshes[0]];
    if (index == AL_NO_INDEX) {
        for (unsigned i = 0; i < node->mNumMeshes && !status; i++)
            status = append_triangles(job, job->file->mMeshes[node->mMeshes[i]], error);
        if (status || !job->corners.count) return status;
        if (!even) al_corners_transform(&job->corners, 0, rest);
        status = finish_mesh(job, node->mName.data, &index, error);
        if (status) return status;
        if (even && node->mNumMeshes == 1) shared[node->mMeshes[0]] = index;
    }
    status = add_instance(job, node->mName.data, index, even ? world : rigid, error);
    return status ? status
                  : bind(job, AL_MOTION_INSTANCE, job->import->scene.instance_count - 1, node, even ? world : rigid,
                         error);
}

static al_status add_nodes(mesh_import *job, const struct aiNode *node, uint32_t *shared, int depth,
                           al_error *error)
{
    if (depth > NODE_DEPTH_LIMIT)
        return al_fail(error, AL_BAD_INPUT, "%s: nodes are nested more than %d deep", job->use->name,
                       NODE_DEPTH_LIMIT);
    al_status status = node->mNumMeshes ? add_node(job, node, shared, error) : AL_OK;
    for (unsigned i = 0; i < node->mNumChildren && !status; i++)
        status = add_nodes(job, node->mChildren[i], shared, depth + 1, error);
    return status;
}

static al_status add_opaque(mesh_import *job, const struct aiNode *root, al_error *error)
{
    uint32_t *shared = malloc((job->file->mNumMeshes + (size_t)1) * sizeof *shared);
    if (!shared) return out_of_memory(job, error);
    for (unsigned i = 0; i < job->file->mNumMeshes; i++) shared[i] = AL_NO_INDEX;
    al_status status = add_nodes(job, root, shared, 0, error);
    free(shared);
    return status;
}

static al_status add_geometry(mesh_import *job, const struct aiNode *root, al_error *error)
{
    double to_object[16];
    if (!job->use->object) return job->mesh->hidden ? AL_OK : add_opaque(job, root, error);
    al_matrix_invert(job->use->object, to_object);
    al_status status = gather_nodes(job, root, to_object, 0, error);
    return status ? status : add_whole(job, job->use->object, error);
}

/* --- lights and cameras --- */

/* Of the supported formats only glTF has them: in their node's space, at its origin, looking or shining along
 * -z with +y up. (What assimp says of their places is the node's translation a second time, now and then.) */

/* The unit vector that a local axis becomes; `axis` 1 or 2, for +y or -z. */
static void axis_in_world(const double m[16], int axis, float out[3])
{
    const double *v = m + axis * 4;
    double length = sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]), sign = axis == 2 ? -1 : 1;
    for (int i = 0; i < 3; i++)
        out[i] = length > 0 ? (float)(sign * v[i] / length) : (float)sign * (i == axis);
}

static al_status add_light(mesh_import *job, const struct aiLight *from, const struct aiNode *node,
                           al_error *error)
{
    al_scene *scene = &job->import->scene;
    double world[16];
    if (from->mType != aiLightSource_POINT && from->mType != aiLightSource_DIRECTIONAL)
        return al_fail(error, AL_BAD_INPUT,
                       "%s: light \"%s\" is neither point nor directional; remove it, or set "
                       "\"import_lights\": false",
                       job->use->name, from->mName.data);
    al_light *light = al_scene_append(scene, &scene->lights, &scene->light_count, sizeof *light);
    if (!light) return out_of_memory(job, error);
    light->name = al_scene_text(scene, from->mName.data);
    if (!light->name) return out_of_memory(job, error);
    node_to_world(job, node, world);
    light->type = from->mType == aiLightSource_POINT ? AL_LIGHT_POINT : AL_LIGHT_DIRECTIONAL;
    axis_in_world(world, 2, light->vector);
    const float color[3] = {from->mColorDiffuse.r, from->mColorDiffuse.g, from->mColorDiffuse.b};
    for (int i = 0; i < 3; i++) {
        if (light->type == AL_LIGHT_POINT) light->vector[i] = (float)world[12 + i];
        light->intensity[i] = color[i];
        if (!(color[i] >= 0) || !isfinite(color[i]))
            return al_fail(error, AL_BAD_INPUT, "%s: light \"%s\" has the intensity %g; 0 or more is right",
                           job->use->name, from->mName.data, color[i]);
    }
    return bind(job, AL_MOTION_LIGHT, scene->light_count - 1, node, world, error);
}

static al_status add_camera(mesh_import *job, uint32_t index, const struct aiNode *node, al_error *error)
{
    const char *name = job->file->mCameras[index]->mName.data;
    al_scene *scene = &job->import->scene;
    double world[16];
    al_camera *camera = al_scene_append(scene, &scene->cameras, &scene->camera_count, sizeof *camera);
    if (!camera) return out_of_memory(job, error);
    camera->name = al_scene_text(scene, name);
    if (!camera->name) return out_of_memory(job, error);
    node_to_world(job, node, world);
    float forward[3];
    axis_in_world(world, 2, forward);
    axis_in_world(world, 1, camera->up);
    for (int i = 0; i < 3; i++) {
        camera->position[i] = (float)world[12 + i];
        camera->target[i] = camera->position[i] + forward[i];
    }
    camera->fov_y_radians = index < job->extras.camera_count ? job->extras.fov_y_radians[index] : 0;
    if (!(camera->fov_y_radians > 1e-4f && camera->fov_y_radians < 3.13f))
        return al_fail(error, AL_BAD_INPUT,
                       "%s: camera \"%s\" has a field of view of %g radians; a perspective camera "
                       "is right, or \"import_cameras\": false",
                       job->use->name, name, camera->fov_y_radians);
    return bind(job, AL_MOTION_CAMERA, scene->camera_count - 1, node, world, error);
}

static al_status add_lights_and_cameras(mesh_import *job, const struct aiNode *root, al_error *error)
{
    al_status status = AL_OK;
    for (unsigned i = 0; i < job->file->mNumLights && job->mesh->import_lights && !status; i++) {
        const struct aiNode *node = find_node(job->file->mRootNode, job->file->mLights[i]->mName.data);
        if (node && is_inside(node, root)) status = add_light(job, job->file->mLights[i], node, error);
    }
    for (unsigned i = 0; i < job->file->mNumCameras && job->mesh->import_cameras && !status; i++) {
        const struct aiNode *node = find_node(job->file->mRootNode, job->file->mCameras[i]->mName.data);
        if (node && is_inside(node, root)) status = add_camera(job, i, node, error);
    }
    return status;
}

/* --- KHR_materials_volume --- */

static al_status read_absorption(const mesh_import *job, al_error *error)
{
    const al_scene_description *description = job->import->description;
    al_status status = AL_OK;
    for (uint32_t i = 0; i < description->medium_count && !status; i++) {
        const al_medium_description *medium = &description->media[i];
        if (strcmp(medium->absorption_mesh, job->mesh->name) == 0)
            status = al_material_absorption(job->file, medium->absorption_material, job->mesh->unit_m,
                                            job->use->name, job->import->scene.media[i].sigma_a_per_m, error);
    }
    return status;
}

/* --- both kinds of mesh --- */

static al_status import_file(mesh_import *job, al_error *error)
{
    al_status status = load_file(job, error);
    if (status) return status;
    const struct aiNode *root = job->file->mRootNode;
    if (job->gltf) status = open_motion(job, error);
    if (status) return status;
    if (*job->mesh->node) root = find_node(root, job->mesh->node);
    if (!root)
        return al_fail(error, AL_BAD_INPUT, "%s: no node is named \"%s\"", job->use->name, job->mesh->node);
    status = add_geometry(job, root, error);
    if (!status) status = add_lights_and_cameras(job, root, error);
    if (!status && job->motion) status = al_gltf_motion_finish(job->motion, error);
    return status ? status : read_absorption(job, error);
}

static al_status read_off(mesh_import *job, al_error *error)
{
    uint8_t *bytes;
    size_t size;
    if (*job->mesh->node)
        return al_fail(error, AL_BAD_INPUT, "%s: OFF files have no nodes; remove \"node\"", job->use->name);
    al_status status = al_inputs_read(job->import, job->mesh->file, &bytes, &size, error);
    if (!status) status = al_off_corners(job->use->name, (const char *)bytes, &job->corners, error);
    free(bytes);
    return status;
}

/* Shapes and OFF files: one mesh, no materials of their own. */
static al_status import_bare(mesh_import *job, al_error *error)
{
    double rigid[16], rest[16];
    const struct aiMesh no_file = {.mMaterialIndex = UINT32_MAX};
    const struct aiScene no_scene = {.mNumMaterials = 0};
    uint32_t material;
    job->file = &no_scene;
    al_status status = job->mesh->shape.type ? al_shape_corners(&job->mesh->shape, &job->corners, error)
                                             : read_off(job, error);
    if (!status && !job->use->object && job->mesh->hidden) goto cleanup;
    if (!status) status = material_of(job, &no_file, &material, error);
    if (!status) status = add_submesh(job, material, 0, error);
    if (status) goto cleanup;
    if (job->use->object) {
        memcpy(rigid, job->use->object, sizeof rigid);
        al_matrix_invert(rigid, rest);
        al_matrix_multiply(rest, job->placement, rest);
    } else {
        al_matrix_split(job->placement, rigid, rest);
    }
    al_corners_transform(&job->corners, 0, rest);
    status = add_whole(job, rigid, error);
cleanup:
    if (!status) status = read_absorption(job, error); /* there is none: refused */
    job->file = NULL;
    return status;
}

static bool is_bare(const al_mesh_description *mesh)
{
    const char *ending = strrchr(mesh->file, '.');
    return mesh->shape.type || (ending && strcasecmp(ending, ".off") == 0);
}

al_status al_mesh_file_import(al_import *import, const al_mesh_description *mesh, const al_mesh_use *use,
                              al_error *error)
{
    mesh_import job = {.import = import, .mesh = mesh, .use = use, .entry_node = AL_NO_INDEX};
    memcpy(job.placement, mesh->transform, sizeof job.placement);
    for (int i = 0; i < 12; i++) job.placement[i] *= mesh->unit_m;
    al_status status = AL_OK;
    if (use->motion->count)
        status = al_motion_add_keys(import, mesh->name, use->motion, use->pivot_m, &job.entry_node, error);
    if (!status) status = is_bare(mesh) ? import_bare(&job, error) : import_file(&job, error);
    al_gltf_motion_close(job.motion);
    al_gltf_close(job.gltf);
    free(job.gltf_nodes);
    if (job.file) aiReleaseImport(job.file);
    al_corners_free(&job.corners);
    al_gltf_extras_free(&job.extras);
    free(job.submeshes);
    free(job.materials);
    return status;
}
