#define _POSIX_C_SOURCE 200809L
#include "airlight/container.h"

#include <assert.h>
#include <errno.h>
#include <fcntl.h>
#include <inttypes.h>
#include <stdlib.h>
#include <string.h>
#include <sys/mman.h>
#include <sys/stat.h>
#include <unistd.h>
#include <xxhash.h>

#include "file_check.h"
#include "kinds.h"
#include "layout.h"

const uint8_t al_magic[AL_MAGIC_SIZE] = {0x8b, 'A', 'I', 'R', '\r', '\n', 0x1a, '\n'};

struct al_file {
    char *name;
    const uint8_t *bytes;
    size_t size;
    void *mapping; /* what to unmap, NULL for memory */
    uint16_t major, minor;
    al_kind kind;
    char writer[AL_WRITER_SIZE];
    uint64_t table_offset;
    size_t chunk_count;
    al_chunk *chunks;
};

uint64_t al_header_checksum(const uint8_t header[AL_HEADER_SIZE], const uint8_t *table, size_t table_size)
{
    return XXH64(table, table_size, XXH64(header, AL_HEADER_CHECKED_SIZE, 0));
}

/* --- structure: header and chunk table --- */

static bool check_identity(al_file *file, al_report *report)
{
    const uint8_t *b = file->bytes;
    if (file->size < AL_HEADER_SIZE) {
        al_report_finding(report, AL_RULE_SIZE,
                          "the file has %zu bytes, an asset has at least %d: it is no asset or was cut off",
                          file->size, AL_HEADER_SIZE);
        return false;
    }
    if (memcmp(b, al_magic, AL_MAGIC_SIZE)) {
        al_report_finding(report, AL_RULE_MAGIC,
                          "this is no airlight asset: the first 8 bytes should be 8B 41 49 52 0D 0A 1A 0A");
        return false;
    }
    file->major = al_get_u16(b + 8);
    file->minor = al_get_u16(b + 10);
    if (file->major != AL_FORMAT_MAJOR) {
        al_report_finding(report, AL_RULE_MAJOR, "format version %u.%u, this program reads %d.x: %s",
                          file->major, file->minor, AL_FORMAT_MAJOR,
                          file->major > AL_FORMAT_MAJOR
                              ? "update airlight, or bake the asset again with this version"
                              : "no such version was ever written, the file is damaged");
        return false;
    }
    return true;
}

static bool check_table(al_file *file, al_report *report)
{
    const uint8_t *b = file->bytes;
    uint64_t size = al_get_u64(b + 16), table = al_get_u64(b + 24), count = al_get_u32(b + 32);
    if (size != file->size) {
        al_report_finding(report, AL_RULE_FILE_SIZE,
                          "the header says %" PRIu64 " bytes, the file has %zu: it was cut off or added to",
                          size, file->size);
        return false;
    }
    if (table < AL_HEADER_SIZE || table % AL_ALIGNMENT || table > size ||
        size - table != count * AL_ENTRY_SIZE) {
        al_report_finding(report, AL_RULE_TABLE,
                          "a table of %" PRIu64 " chunks at offset %" PRIu64
                          " does not end a file of %" PRIu64 " bytes",
                          count, table, size);
        return false;
    }
    uint64_t stored = al_get_u64(b + AL_HEADER_CHECKED_SIZE);
    uint64_t computed = al_header_checksum(b, b + table, (size_t)(size - table));
    if (stored != computed) {
        al_report_finding(report, AL_RULE_HEADER_CHECKSUM,
                          "header and chunk table have checksum %016" PRIx64 ", stored is %016" PRIx64
                          ": the file is damaged, bake it again",
                          computed, stored);
        return false;
    }
    file->table_offset = table;
    file->chunk_count = (size_t)count;
    return true;
}

static void check_header_fields(al_file *file, al_report *report)
{
    const uint8_t *b = file->bytes;
    file->kind = (al_kind)al_get_u32(b + 12);
    const al_kind_rules *kind = al_kind_find(file->kind);
    if (!kind || !kind->check)
        al_report_finding(report, AL_RULE_KIND,
                          "assets of kind %u (%s) are not known to this version: update airlight",
                          (unsigned)file->kind, al_kind_name(file->kind));
    if (file->minor <= AL_FORMAT_MINOR &&
        !(al_all_zero(b + 36, 4) && al_all_zero(b + AL_RESERVED_OFFSET, AL_RESERVED_SIZE)))
        al_report_finding(report, AL_RULE_RESERVED, "reserved bytes of the header are not zero");
    const uint8_t *writer = b + AL_WRITER_OFFSET;
    size_t length = 0;
    while (length < AL_WRITER_SIZE && writer[length] >= 0x20 && writer[length] < 0x7f) length++;
    if (length == 0 || length == AL_WRITER_SIZE || !al_all_zero(writer + length, AL_WRITER_SIZE - length))
        al_report_finding(report, AL_RULE_WRITER,
                          "the writer's name is empty or no zero-padded printable text");
    else
        memcpy(file->writer, writer, length);
}

static void read_entry(const uint8_t *entry, al_chunk *chunk)
{
    *chunk = (al_chunk){.version = al_get_u16(entry + 4),
                        .flags = al_get_u32(entry + 8),
                        .offset = al_get_u64(entry + 16),
                        .size = al_get_u64(entry + 24),
                        .raw_size = al_get_u64(entry + 32),
                        .checksum = al_get_u64(entry + 40)};
    for (int i = 0; i < 4; i++) {
        bool good = (entry[i] >= 'A' && entry[i] <= 'Z') || (entry[i] >= '0' && entry[i] <= '9');
        chunk->type[i] = good ? (char)entry[i] : '?';
    }
}

static void check_entry(const al_file *file, size_t index, const uint8_t *entry, al_report *report)
{
    const al_chunk *c = &file->chunks[index];
    bool newer = file->minor > AL_FORMAT_MINOR;
    uint32_t unknown = c->flags & ~(uint32_t)AL_CHUNK_OPTIONAL;
    if (strchr(c->type, '?'))
        al_report_finding(report, AL_RULE_CHUNK_TYPE,
                          "chunk %zu: the type %02X %02X %02X %02X is not four of A to Z and 0 to 9", index,
                          entry[0], entry[1], entry[2], entry[3]);
    if (!newer && !(al_all_zero(entry + 6, 2) && al_all_zero(entry + 12, 4)))
        al_report_finding(report, AL_RULE_RESERVED,
                          "chunk %zu (%s): reserved bytes of its table entry are not zero", index, c->type);
    if (newer ? unknown & ~AL_FLAGS_IGNORABLE : unknown)
        al_report_finding(report, AL_RULE_CHUNK_FLAGS,
                          "chunk %zu (%s): flags %08" PRIx32
                          " are not known to this version: update airlight",
                          index, c->type, c->flags);
    if (c->raw_size != c->size)
        al_report_finding(report, AL_RULE_CHUNK_RAW_SIZE,
                          "chunk %zu (%s): raw size %" PRIu64 " is not the stored size %" PRIu64, index,
                          c->type, c->raw_size, c->size);
}

/* True when the chunk lies where it must; `expected` moves behind it where it lies. */
static bool check_place(const al_file *file, size_t index, uint64_t *expected, al_report *report)
{
    const al_chunk *c = &file->chunks[index];
    if (c->offset > file->table_offset || c->size > file->table_offset - c->offset ||
        al_padded(c->size) > file->table_offset - c->offset) {
        al_report_finding(report, AL_RULE_CHUNK_INSIDE,
                          "chunk %zu (%s): %" PRIu64 " bytes at offset %" PRIu64
                          " reach into the table at %" PRIu64,
                          index, c->type, c->size, c->offset, file->table_offset);
        return false;
    }
    bool good = c->offset == *expected, overlap = c->offset < *expected;
    if (!good)
        al_report_finding(report, overlap ? AL_RULE_CHUNK_OVERLAP : AL_RULE_CHUNK_GAP,
                          "chunk %zu (%s): begins at offset %" PRIu64 " instead of %" PRIu64 ", %s", index,
                          c->type, c->offset, *expected,
                          overlap ? "inside the one before" : "which leaves a gap");
    *expected = c->offset + al_padded(c->size);
    return good;
}

static void check_types(const al_file *file, const al_kind_rules *kind, al_report *report)
{
    for (size_t i = 0; i < file->chunk_count; i++) {
        const al_chunk *c = &file->chunks[i];
        const al_chunk_rules *rules = al_chunk_find(kind, c->type);
        if (c->flags & AL_CHUNK_OPTIONAL) continue;
        if (!rules)
            al_report_finding(report, AL_RULE_CHUNK_UNKNOWN,
                              "chunk %zu (%s): required, but unknown to this version: update airlight, or "
                              "bake the asset again with this version",
                              i, c->type);
        else if (c->version > rules->version)
            al_report_finding(report, AL_RULE_CHUNK_VERSION,
                              "chunk %zu (%s): version %u, this program reads up to %u: update airlight, or "
                              "bake the asset again with this version",
                              i, c->type, c->version, rules->version);
    }
    for (const al_chunk_rules *rules = kind->chunks; rules < kind->chunks + kind->chunk_count; rules++) {
        uint32_t count = 0;
        for (size_t i = 0; i < file->chunk_count; i++) count += al_chunk_is(file, i, rules->type);
        if (count < rules->minimum || (rules->maximum && count > rules->maximum))
            al_report_finding(report, AL_RULE_CHUNK_COUNT,
                              "%" PRIu32 " chunks %s, an asset of kind %s has %s %" PRIu32, count,
                              rules->type, kind->name, count < rules->minimum ? "at least" : "at most",
                              count < rules->minimum ? rules->minimum : rules->maximum);
    }
}

/* Fills the file from its bytes. Findings go to the report; what they leave undone is never looked at. */
static void parse(al_file *file, al_report *report)
{
    if (!check_identity(file, report) || !check_table(file, report)) return;
    check_header_fields(file, report);
    file->chunks = calloc(file->chunk_count ? file->chunk_count : 1, sizeof *file->chunks);
    if (!file->chunks) {
        al_report_out_of_memory(report);
        return;
    }
    uint64_t expected = AL_HEADER_SIZE;
    bool placed = true;
    for (size_t i = 0; i < file->chunk_count; i++) {
        const uint8_t *entry = file->bytes + file->table_offset + i * AL_ENTRY_SIZE;
        read_entry(entry, &file->chunks[i]);
        check_entry(file, i, entry, report);
        placed = check_place(file, i, &expected, report) && placed;
    }
    if (placed && expected != file->table_offset)
        al_report_finding(report, AL_RULE_CHUNK_GAP,
                          "the table begins at offset %" PRIu64 " instead of %" PRIu64 ", which leaves a gap",
                          file->table_offset, expected);
    const al_kind_rules *kind = al_kind_find(file->kind);
    if (kind && kind->check) check_types(file, kind, report);
}

/* --- opening --- */

static al_status make_file(const char *name, al_file **file, al_error *error)
{
    size_t size = strlen(name) + 1;
    *file = calloc(1, sizeof **file);
    char *copy = malloc(size);
    if (!*file || !copy) {
        free(*file);
        free(copy);
        *file = NULL;
        return al_fail(error, AL_IO, "%s: out of memory", name);
    }
    (*file)->name = memcpy(copy, name, size);
    return AL_OK;
}

/* Maps `path`; size 0 maps nothing. */
static al_status map_file(al_file *file, const char *path, uint64_t limit, al_error *error)
{
    struct stat about;
    al_status status = AL_OK;
    int descriptor = open(path, O_RDONLY | O_CLOEXEC | O_NONBLOCK); /* a pipe without a writer must not block */
    if (descriptor < 0) return al_fail_errno(error, file->name, "open");
    if (fstat(descriptor, &about) != 0) {
        status = al_fail_errno(error, file->name, "read");
    } else if (!S_ISREG(about.st_mode)) {
        status = al_fail(error, AL_BAD_INPUT, "%s: is no regular file, an asset is one", file->name);
    } else if ((limit && (uint64_t)about.st_size > limit) || (uint64_t)about.st_size > SIZE_MAX) {
        status = al_fail(error, AL_BAD_INPUT, "%s: has %" PRIu64 " bytes, the limit is %" PRIu64, file->name,
                         (uint64_t)about.st_size, limit ? limit : (uint64_t)SIZE_MAX);
    } else if (about.st_size > 0) {
        void *mapping = mmap(NULL, (size_t)about.st_size, PROT_READ, MAP_PRIVATE, descriptor, 0);
        if (mapping == MAP_FAILED) {
            status = al_fail(error, AL_IO, "%s: cannot map: %s", file->name, strerror(errno));
        } else {
            file->mapping = mapping;
            file->bytes = mapping;
            file->size = (size_t)about.st_size;
        }
    }
    close(descriptor);
    return status;
}

static al_status set_memory(al_file *file, const void *data, size_t size, uint64_t limit, al_error *error)
{
    assert((uintptr_t)data % 8 == 0);
    if (limit && size > limit)
        return al_fail(error, AL_BAD_INPUT, "%s: has %zu bytes, the limit is %" PRIu64, file->name, size,
                       limit);
    file->bytes = data;
    file->size = size;
    return AL_OK;
}

/* Parses what has been mapped or set; closes the file on failure. */
static al_status finish_open(const al_open_options *options, al_status status, al_file **file,
                             al_error *error)
{
    if (status == AL_OK) {
        al_report report = {.name = (*file)->name, .error = error};
        parse(*file, &report);
        status = report.status;
    }
    if (status == AL_OK && options && options->kind != AL_KIND_NONE && (*file)->kind != options->kind)
        status = al_fail(error, AL_BAD_INPUT, "%s: is an asset of kind %s, wanted is %s", (*file)->name,
                         al_kind_name((*file)->kind), al_kind_name(options->kind));
    if (status != AL_OK) {
        al_file_close(*file);
        *file = NULL;
    }
    return status;
}

al_status al_file_open(const char *path, const al_open_options *options, al_file **file, al_error *error)
{
    al_status status = make_file(path, file, error);
    if (status != AL_OK) return status;
    status = map_file(*file, path, options ? options->size_limit : 0, error);
    return finish_open(options, status, file, error);
}

al_status al_file_from_memory(const char *name, const void *data, size_t size, const al_open_options *options,
                              al_file **file, al_error *error)
{
    al_status status = make_file(name, file, error);
    if (status != AL_OK) return status;
    status = set_memory(*file, data, size, options ? options->size_limit : 0, error);
    return finish_open(options, status, file, error);
}

void al_file_close(al_file *file)
{
    if (!file) return;
    if (file->mapping) munmap(file->mapping, file->size);
    free(file->chunks);
    free(file->name);
    free(file);
}

/* --- access --- */

const char *al_file_name(const al_file *file)
{
    return file->name;
}

al_kind al_file_kind(const al_file *file)
{
    return file->kind;
}

uint64_t al_file_size(const al_file *file)
{
    return file->size;
}

uint16_t al_file_major(const al_file *file)
{
    return file->major;
}

uint16_t al_file_minor(const al_file *file)
{
    return file->minor;
}

const char *al_file_writer(const al_file *file)
{
    return file->writer;
}

size_t al_file_chunk_count(const al_file *file)
{
    return file->chunk_count;
}

const al_chunk *al_file_chunk(const al_file *file, size_t index)
{
    assert(index < file->chunk_count);
    return &file->chunks[index];
}

bool al_chunk_is(const al_file *file, size_t index, const char type[5])
{
    const al_chunk *c = &file->chunks[index];
    if (memcmp(c->type, type, 4)) return false;
    const al_kind_rules *kind = al_kind_find(file->kind);
    const al_chunk_rules *rules = kind ? al_chunk_find(kind, type) : NULL;
    return !rules || c->version <= rules->version;
}

ptrdiff_t al_file_find(const al_file *file, const char type[5], size_t n)
{
    for (size_t i = 0; i < file->chunk_count; i++)
        if (al_chunk_is(file, i, type) && n-- == 0) return (ptrdiff_t)i;
    return -1;
}

static void check_data(const al_file *file, size_t index, al_report *report)
{
    const al_chunk *c = &file->chunks[index];
    const uint8_t *bytes = file->bytes + c->offset;
    uint64_t computed = XXH64(bytes, (size_t)al_padded(c->size), 0);
    if (computed != c->checksum)
        al_report_finding(report, AL_RULE_CHUNK_CHECKSUM,
                          "chunk %zu (%s, %" PRIu64 " bytes at offset %" PRIu64
                          "): its checksum is %016" PRIx64 ", stored is %016" PRIx64
                          ": the file is damaged, bake it again",
                          index, c->type, c->size, c->offset, computed, c->checksum);
    if (!al_all_zero(bytes + c->size, al_padded(c->size) - c->size))
        al_report_finding(report, AL_RULE_CHUNK_PADDING, "chunk %zu (%s): the padding behind it is not zero",
                          index, c->type);
}

al_status al_file_data(const al_file *file, size_t index, const void **data, size_t *size, al_error *error)
{
    assert(index < file->chunk_count);
    al_report report = {.name = file->name, .error = error};
    check_data(file, index, &report);
    bool good = report.status == AL_OK;
    *data = good ? file->bytes + file->chunks[index].offset : NULL;
    *size = good ? (size_t)file->chunks[index].size : 0;
    return report.status;
}

/* --- checking everything --- */

static al_status check_all(al_file *file, al_status status, al_finding_fn *on_finding, void *user,
                           al_error *error)
{
    if (status == AL_OK) {
        al_report report = {.name = file->name, .on_finding = on_finding, .user = user, .error = error};
        parse(file, &report);
        if (report.status == AL_OK) {
            for (size_t i = 0; i < file->chunk_count; i++) check_data(file, i, &report);
            al_kind_find(file->kind)->check(file, &report);
            al_check_provenance(file, &report);
            al_check_measured(file, &report);
        }
        status = report.status;
    }
    al_file_close(file);
    return status;
}

al_status al_file_check_as(const char *path, const char *name, al_finding_fn *on_finding, void *user,
                           al_error *error)
{
    al_file *file;
    al_status status = make_file(name, &file, error);
    if (status != AL_OK) return status;
    return check_all(file, map_file(file, path, 0, error), on_finding, user, error);
}

al_status al_file_check(const char *path, al_finding_fn *on_finding, void *user, al_error *error)
{
    return al_file_check_as(path, path, on_finding, user, error);
}

al_status al_file_check_memory(const char *name, const void *data, size_t size, al_finding_fn *on_finding,
                               void *user, al_error *error)
{
    al_file *file;
    al_status status = make_file(name, &file, error);
    if (status != AL_OK) return status;
    return check_all(file, set_memory(file, data, size, 0, error), on_finding, user, error);
}
