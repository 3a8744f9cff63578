/* Every validation rule with its permanent number: numbers are never used again for something else. The text
 * says what a valid file keeps. docs/formats.md lists the same; a test holds them together. */
#ifndef AIRLIGHT_RULES_H
#define AIRLIGHT_RULES_H

#define AL_RULES(RULE) \
    RULE(AL_RULE_SIZE, 101, "a file has at least the 128 bytes of the header") \
    RULE(AL_RULE_MAGIC, 102, "a file begins with the magic bytes 8B 41 49 52 0D 0A 1A 0A") \
    RULE(AL_RULE_MAJOR, 103, "the major version is 1") \
    RULE(AL_RULE_FILE_SIZE, 104, "the size in the header is the size of the file") \
    RULE(AL_RULE_TABLE, 105, "the chunk table lies at a multiple of 64 and ends the file") \
    RULE(AL_RULE_HEADER_CHECKSUM, 106, "the header's checksum is that of header and chunk table") \
    RULE(AL_RULE_KIND, 107, "the kind is one that this version reads") \
    RULE(AL_RULE_RESERVED, 108, "reserved bytes are zero unless the minor version is newer") \
    RULE(AL_RULE_WRITER, 109, "the writer is printable ASCII, not empty, terminated and zero-padded") \
    RULE(AL_RULE_CHUNK_TYPE, 110, "a chunk's type is four of A to Z and 0 to 9") \
    RULE(AL_RULE_CHUNK_INSIDE, 111, "a chunk and its padding lie between header and chunk table") \
    RULE(AL_RULE_CHUNK_OVERLAP, 112, "chunks do not overlap and stand in the order of the table") \
    RULE(AL_RULE_CHUNK_GAP, 113, "each chunk begins where the padding of the one before ends") \
    RULE(AL_RULE_CHUNK_FLAGS, 114, "of the flags, bit 0 is known; bits 16 to 31 may be newer") \
    RULE(AL_RULE_CHUNK_RAW_SIZE, 115, "the raw size is the stored size") \
    RULE(AL_RULE_CHUNK_CHECKSUM, 116, "a chunk's checksum is that of its bytes and padding") \
    RULE(AL_RULE_CHUNK_PADDING, 117, "the padding behind a chunk is zero") \
    RULE(AL_RULE_CHUNK_UNKNOWN, 118, "a chunk of unknown type is optional") \
    RULE(AL_RULE_CHUNK_VERSION, 119, "a chunk of newer version is optional") \
    RULE(AL_RULE_CHUNK_COUNT, 120, "each chunk type stands as often as the kind asks") \
    RULE(AL_RULE_RECORD_SIZE, 130, "a chunk of records has the size of its records") \
    RULE(AL_RULE_FINITE, 131, "every number is finite") \
    RULE(AL_RULE_RANGE, 132, "every field lies in its range") \
    RULE(AL_RULE_TEXT, 133, "a text begins inside chunk TEXT, which ends with a zero byte") \
    RULE(AL_RULE_PROVENANCE, 134, "chunk PROV is a JSON object") \
    RULE(AL_RULE_MEASURED_TEXT, 135, "the texts in chunk MEAS are UTF-8, begin and end with a zero byte") \
    RULE(AL_RULE_TRANSLUCENT_CHANNELS, 201, "there are one or three sets of coefficients") \
    RULE(AL_RULE_TRANSLUCENT_DIRECTIONS, 202, "the number of directions is even") \
    RULE(AL_RULE_TRANSLUCENT_BOUNDS, 203, "the lower bound is not above the upper one") \
    RULE(AL_RULE_TRANSLUCENT_PAGES, 204, "there are as many pages as the samples fill") \
    RULE(AL_RULE_TRANSLUCENT_PAGE_SIZE, 205, "a page has the size its samples need") \
    RULE(AL_RULE_TRANSLUCENT_PAGE_PADDING, 206, "bytes between the arrays of a page are zero") \
    RULE(AL_RULE_TRANSLUCENT_INSIDE, 207, "a sample lies in the bounds, widened by its radius") \
    RULE(AL_RULE_TRANSLUCENT_GAUSSIAN, 208, "a Gaussian has a > 0, weight >= 0, radius > 0, density >= 0") \
    RULE(AL_RULE_TRANSLUCENT_SCALE, 209, "a scale of 8-bit coefficients is not negative") \
    RULE(AL_RULE_TRANSLUCENT_BYTE, 210, "an 8-bit coefficient is not -128") \
    RULE(AL_RULE_TRANSLUCENT_GRID, 211, "the density grid has two bytes a voxel") \
    RULE(AL_RULE_TRANSLUCENT_BLOCKERS, 212, "blockers are there when INFO says so, one byte a voxel") \
    RULE(AL_RULE_SCENE_GEOMETRY_COUNT, 301, "there is one GEOM chunk for each mesh") \
    RULE(AL_RULE_SCENE_GEOMETRY_SIZE, 302, "a GEOM chunk has the size its mesh needs") \
    RULE(AL_RULE_SCENE_PIXEL_COUNT, 303, "there is one PIXL chunk for each texture") \
    RULE(AL_RULE_SCENE_PIXEL_SIZE, 304, "a PIXL chunk has the size its texture needs") \
    RULE(AL_RULE_SCENE_INDEX, 305, "an index names something that is there") \
    RULE(AL_RULE_SCENE_TRIANGLES, 306, "indices come in threes") \
    RULE(AL_RULE_SCENE_SUBMESHES, 307, "the submeshes of a mesh lie in its indices, SUBM holds them all") \
    RULE(AL_RULE_SCENE_UNIT, 308, "normals and the directions of lights have length 1 within 1 %") \
    RULE(AL_RULE_SCENE_ROLE, 309, "an instance names a translucent object just when its role needs one") \
    RULE(AL_RULE_SCENE_BOUNDARY, 310, "a translucent object and its boundary's instance name each other") \
    RULE(AL_RULE_SCENE_AFFINE, 311, "the last row of a world matrix is 0 0 0 1") \
    RULE(AL_RULE_SCENE_ASSET, 312, "an asset's name is a plain file name or empty") \
    RULE(AL_RULE_SCENE_CAMERA, 313, "a camera does not stand on its target and has an up direction") \
    RULE(AL_RULE_SCENE_CAMERAS, 314, "there is at least one camera") \
    RULE(AL_RULE_SCENE_ENVIRONMENT, 315, "ENVM holds the pixels of the environment, if there is one") \
    RULE(AL_RULE_SCENE_GEOMETRY_PADDING, 316, "bytes between the arrays of a GEOM chunk are zero") \
    RULE(AL_RULE_SCENE_LIGHTING, 317, "only opaque instances are lit by a lightmap or probes") \
    RULE(AL_RULE_SCENE_FOG, 318, "a fog has its lower bounds below the upper ones, or none and zeros") \
    RULE(AL_RULE_SCENE_NODE_ORDER, 319, "a node's parent stands before it") \
    RULE(AL_RULE_SCENE_CHANNEL, 320, "channels ascend by node and property, with the numbers that these have") \
    RULE(AL_RULE_SCENE_KEYS, 321, "KEYS has the size its channels need") \
    RULE(AL_RULE_SCENE_KEY_TIMES, 322, "the times of a channel's keys rise, from 0 on") \
    RULE(AL_RULE_SCENE_BINDING_ORDER, 323, "bindings ascend by kind and what they bind") \
    RULE(AL_RULE_SCENE_DEFORM, 324, "deforms ascend; their instances are opaque, without lightmap, alone with their mesh") \
    RULE(AL_RULE_SCENE_SHAPE, 325, "there is one SHAP chunk for each deform, with the size it needs and zeros between") \
    RULE(AL_RULE_SCENE_JOINTS, 326, "a vertex names joints that are there, its weights are from 0 and sum to 1 within 1 %") \
    RULE(AL_RULE_IMPULSE_RANGE, 401, "the tabulated distances rise") \
    RULE(AL_RULE_IMPULSE_COUNT, 402, "there is one TABL chunk for each table") \
    RULE(AL_RULE_IMPULSE_SIZE, 403, "a TABL chunk has the size its counts need") \
    RULE(AL_RULE_IMPULSE_NUMBERS, 404, "an entry has the numbers that its emitter and axis need") \
    RULE(AL_RULE_IMPULSE_COSINES, 405, "tables of the area emitter have an odd number of cosines, 7 or more, others 1") \
    RULE(AL_RULE_IMPULSE_EVENTS, 406, "the events of a table lie in those of the file, first to last") \
    RULE(AL_RULE_IMPULSE_ANGLES, 407, "only event 1 is resolved by angle, or has g other than 0") \
    RULE(AL_RULE_IMPULSE_PADDING, 408, "bytes between the arrays of a TABL chunk are zero") \
    RULE(AL_RULE_IMPULSE_TWICE, 409, "no two tables say the same") \
    RULE(AL_RULE_IMPULSE_MISSING, 410, "each emitter has an isotropic table of each event") \
    RULE(AL_RULE_LIGHTMAP_PAGES, 501, "there is one PAGE chunk for each page") \
    RULE(AL_RULE_LIGHTMAP_PAGE_SIZE, 502, "a page has the size its texels need") \
    RULE(AL_RULE_LIGHTMAP_PAGE_PADDING, 503, "bytes between the arrays of a lightmap's page are zero") \
    RULE(AL_RULE_LIGHTMAP_NEGATIVE, 504, "irradiance is not negative") \
    RULE(AL_RULE_LIGHTMAP_STATE, 505, "the state of a texel is 0 to 3") \
    RULE(AL_RULE_LIGHTMAP_GEOMETRY, 506, "VERT and TRIS have the size their counts need") \
    RULE(AL_RULE_LIGHTMAP_INDEX, 507, "instances name pages, triangles name vertices that are there") \
    RULE(AL_RULE_LIGHTMAP_RECTANGLE, 508, "an instance's rectangle and page uv lie in [0, 1]") \
    RULE(AL_RULE_LIGHTMAP_ORDER, 509, "instances ascend and share the triangles out, one after the other") \
    RULE(AL_RULE_LIGHTMAP_SCALE, 510, "a lightmap of floats has scales of 1") \
    RULE(AL_RULE_PROBES_SIZE, 601, "an array of probes has the size its counts need") \
    RULE(AL_RULE_PROBES_INDEX, 602, "a tetrahedron names probes that are there") \
    RULE(AL_RULE_PROBES_VOLUME, 603, "a tetrahedron has a positive volume") \
    RULE(AL_RULE_PROBES_NEIGHBOUR, 604, "neighbours share a face and name each other") \
    RULE(AL_RULE_MEDIUM_INDICES, 701, "a medium has one INDX chunk for each frame") \
    RULE(AL_RULE_MEDIUM_INDEX_SIZE, 702, "an INDX chunk has four bytes for each cell of bricks") \
    RULE(AL_RULE_MEDIUM_NUMBERS, 703, "a frame's bricks are numbered in the order of their cells") \
    RULE(AL_RULE_MEDIUM_PAGES, 704, "there are as many pages as the bricks of all frames fill") \
    RULE(AL_RULE_MEDIUM_PAGE_SIZE, 705, "a page has the size its bricks need") \
    RULE(AL_RULE_MEDIUM_VALUE, 706, "a density is a half from 0 to 32768") \
    RULE(AL_RULE_MEDIUM_BOUNDS, 707, "a medium's lower bounds are below the upper ones") \
    RULE(AL_RULE_MEDIUM_TRANSFORM, 708, "the grid's transform is affine and can be inverted") \
    RULE(AL_RULE_MEDIUM_TIMES, 709, "frames follow each other in time") \
    RULE(AL_RULE_MEDIUM_SKY, 710, "SKYI and SKYL stand together, SKYC with them when SKYI says walled") \
    RULE(AL_RULE_MEDIUM_SKY_SIZE, 711, "SKYL has six bytes a point and number, SKYC eight a cell") \
    RULE(AL_RULE_MEDIUM_SKY_DEPTH, 712, "an optical depth of SKYL is a half from 0 to 64") \
    RULE(AL_RULE_MEDIUM_SKY_PLANES, 713, "each eighth of SKYC takes a plane along each axis") \
    RULE(AL_RULE_MEDIUM_DEPTH, 714, "a medium with DEPI has one DEPL for each frame, one without has none") \
    RULE(AL_RULE_MEDIUM_DEPTH_SIZE, 715, "DEPL has two bytes for each point and coefficient")

#define AL_RULE_ENUM(name, number, text) name = number,
enum al_rule { AL_RULES(AL_RULE_ENUM) };
#undef AL_RULE_ENUM

#endif
