#include "refusals.h"

#define BYTE "translucent_byte_1_0"
#define HALF "translucent_half_1_0"
#define FLOAT "translucent_float_1_0"
#define MEASURED "translucent_measured_1_0"
#define SCENE "scene_1_0"
#define PROBES "probes_1_0"
#define LIT "scene_lit_1_0"
#define MOVING "scene_moving_1_0"
#define MAP "lightmap_half_1_0"
#define MAP_FLOAT "lightmap_float_1_0"
#define MEDIUM "medium_1_0"
#define SKY "medium_sky_1_0"
#define DEPTH "medium_depth_1_0"

#define IMPULSE "impulse_tables_1_0"

#define HEADER(at, count, value) {CHANGE_HEADER, "", 0, at, count, value}
#define ENTRY(type, index, at, count, value) {CHANGE_ENTRY, type, index, at, count, value}
#define CHUNK(type, index, at, count, value) {CHANGE_CHUNK, type, index, at, count, value}
#define SIZE(value) {CHANGE_SIZE, "", 0, 0, 0, value}
#define EMPTY(type, index) {CHANGE_EMPTY, type, index, 0, 0, 0}
#define TEXT(a, b, c, d) ((uint64_t)(a) | (uint64_t)(b) << 8 | (uint64_t)(c) << 16 | (uint64_t)(d) << 24)
/* becomes optional and unknown */
#define HIDE(type, index) \
    ENTRY(type, index, 8, 4, 1), ENTRY(type, index, 0, 4, TEXT('N', 'E', 'W', '1'))
#define RESIZE(type, index, size) ENTRY(type, index, 24, 8, size), ENTRY(type, index, 32, 8, size)
#define NAN_BITS 0x7fc00000
#define MINUS_ONE 0xbf800000

const refusal refusals[] = {
    {0, "accept_newer_minor", BYTE, SEAL_ALL,
     {HEADER(10, 2, 7), HEADER(104, 4, 1), ENTRY("PROV", 0, 0, 4, TEXT('N', 'E', 'W', '1')),
      ENTRY("INFO", 0, 8, 4, 0x80000000)}},
    {0, "accept_newer_optional_chunk_version", BYTE, SEAL_ALL,
     {ENTRY("PROV", 0, 4, 2, 2), CHUNK("PROV", 0, 0, 1, '[')}},

    {101, "cut_below_header", FLOAT, SEAL_NOTHING, {SIZE(127)}},
    {101, "empty_file", FLOAT, SEAL_NOTHING, {SIZE(0)}},
    {102, "wrong_magic", FLOAT, SEAL_ALL, {HEADER(4, 1, '\n')}},
    {103, "newer_major", FLOAT, SEAL_ALL, {HEADER(8, 2, 2)}},
    {103, "major_zero", FLOAT, SEAL_ALL, {HEADER(8, 2, 0)}},
    {104, "cut_off", FLOAT, SEAL_NOTHING, {SIZE(512)}},
    {105, "table_not_at_end", FLOAT, SEAL_ALL, {HEADER(32, 4, 2)}},
    {106, "header_checksum", FLOAT, SEAL_NOTHING, {HEADER(40, 1, 'b')}},
    {107, "unknown_kind", FLOAT, SEAL_ALL, {HEADER(12, 4, 99)}},
    {108, "reserved_header_byte", FLOAT, SEAL_ALL, {HEADER(119, 1, 1)}},
    {108, "reserved_entry_byte", FLOAT, SEAL_ALL, {ENTRY("GRID", 0, 15, 1, 1)}},
    {109, "writer_not_text", FLOAT, SEAL_ALL, {HEADER(44, 1, 7)}},
    {109, "writer_empty", FLOAT, SEAL_ALL,
     {HEADER(40, 8, 0), HEADER(48, 8, 0), HEADER(56, 8, 0), HEADER(64, 8, 0)}},
    {110, "chunk_type_lower_case", BYTE, SEAL_ALL, {ENTRY("PROV", 0, 3, 1, 'v')}},
    {111, "chunk_reaches_table", FLOAT, SEAL_ALL, {RESIZE("PAGE", 0, 1 << 20)}},
    {111, "chunk_size_overflows", FLOAT, SEAL_ALL, {RESIZE("PAGE", 0, UINT64_MAX)}},
    {112, "chunks_overlap", FLOAT, SEAL_ALL, {ENTRY("GRID", 0, 16, 8, 128)}},
    {113, "gap_between_chunks", FLOAT, SEAL_ALL, {RESIZE("INFO", 0, 128)}},
    {114, "unknown_flag", FLOAT, SEAL_ALL, {ENTRY("INFO", 0, 8, 4, 2)}},
    {115, "raw_size", FLOAT, SEAL_ALL, {ENTRY("GRID", 0, 32, 8, 25)}},
    {116, "chunk_checksum", FLOAT, SEAL_NOTHING, {CHUNK("GRID", 0, 0, 1, 0)}},
    {117, "padding_not_zero", FLOAT, SEAL_ALL, {CHUNK("GRID", 0, 63, 1, 1)}},
    {118, "unknown_required_chunk", BYTE, SEAL_ALL,
     {ENTRY("PROV", 0, 8, 4, 0), ENTRY("PROV", 0, 0, 4, TEXT('N', 'E', 'W', '1'))}},
    {119, "newer_chunk_version", FLOAT, SEAL_ALL, {ENTRY("INFO", 0, 4, 2, 2)}},
    {120, "grid_missing", FLOAT, SEAL_ALL, {HIDE("GRID", 0)}},
    {120, "two_infos", FLOAT, SEAL_ALL, {ENTRY("GRID", 0, 0, 4, TEXT('I', 'N', 'F', 'O'))}},
    {130, "info_too_short", FLOAT, SEAL_ALL, {RESIZE("INFO", 0, 144), CHUNK("INFO", 0, 144, 4, 0)}},
    {130, "materials_too_short", SCENE, SEAL_ALL, {RESIZE("MATL", 0, 116), CHUNK("MATL", 0, 116, 4, 0)}},
    {131, "info_not_finite", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 80, 4, NAN_BITS)}},
    {131, "position_not_finite", BYTE, SEAL_ALL, {CHUNK("PAGE", 1, 8, 4, NAN_BITS)}},
    {131, "half_not_finite", HALF, SEAL_ALL, {CHUNK("PAGE", 0, 128, 2, 0xfc00)}},
    {131, "float_not_finite", FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 128, 4, NAN_BITS)}},
    {131, "environment_not_finite", SCENE, SEAL_ALL, {CHUNK("ENVM", 0, 8, 4, NAN_BITS)}},
    {131, "vertex_not_finite", SCENE, SEAL_ALL, {CHUNK("GEOM", 1, 16, 4, NAN_BITS)}},
    {132, "order_too_high", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 8, 4, 9)}},
    {132, "order_zero", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 8, 4, 0)}},
    {132, "page_size_zero", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 4, 4, 0)}},
    {132, "negative_scattering", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 60, 4, MINUS_ONE)}},
    {132, "g_of_one", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 84, 4, 0x3f800000)}},
    {132, "roughness_above_one", SCENE, SEAL_ALL, {CHUNK("MATL", 0, 20, 4, 0x40000000)}},
    {132, "flag_of_two", SCENE, SEAL_ALL, {CHUNK("TEXR", 0, 12, 4, 2)}},
    {132, "environment_negative", SCENE, SEAL_ALL, {CHUNK("ENVM", 0, 8, 4, MINUS_ONE)}},
    {133, "text_outside", SCENE, SEAL_ALL, {CHUNK("LITE", 0, 0, 4, 100000)}},
    {133, "text_not_terminated", SCENE, SEAL_ALL, {CHUNK("TEXT", 0, 96, 1, 'x')}},
    {134, "provenance_no_object", HALF, SEAL_ALL, {CHUNK("PROV", 0, 0, 1, '[')}},
    {130, "measured_too_short", MEASURED, SEAL_ALL, {RESIZE("MEAS", 1, 47), CHUNK("MEAS", 1, 47, 8, 0), CHUNK("MEAS", 1, 55, 8, 0)}},
    {131, "measured_not_finite", MEASURED, SEAL_ALL, {CHUNK("MEAS", 0, 16, 8, 0x7ff0000000000000)}},
    {132, "measured_negative", MEASURED, SEAL_ALL, {CHUNK("MEAS", 0, 32, 8, 0xbff0000000000000)}},
    {132, "measured_of_nothing", MEASURED, SEAL_ALL, {CHUNK("MEAS", 1, 12, 4, 0)}},
    {133, "measured_text_outside", MEASURED, SEAL_ALL, {CHUNK("MEAS", 0, 4, 4, 1000)}},
    {135, "measured_text_cut", MEASURED, SEAL_ALL, {CHUNK("MEAS", 1, 59, 1, 'x')}},
    {135, "measured_text_not_utf8", MEASURED, SEAL_ALL, {CHUNK("MEAS", 0, 50, 1, 0xff)}},

    {201, "two_channels", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 12, 4, 2)}},
    {202, "odd_directions", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 20, 4, 127)}},
    {203, "bounds_inside_out", FLOAT, SEAL_ALL, {CHUNK("INFO", 0, 92, 4, 0x40000000)}},
    {204, "page_missing", BYTE, SEAL_ALL, {HIDE("PAGE", 2)}},
    {204, "page_too_many", HALF, SEAL_ALL, {ENTRY("PROV", 0, 0, 4, TEXT('P', 'A', 'G', 'E'))}},
    {205, "page_too_short", FLOAT, SEAL_ALL, {RESIZE("PAGE", 0, 130), CHUNK("PAGE", 0, 130, 2, 0)}},
    {206, "gap_inside_page", FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 63, 1, 1)}},
    {207, "sample_outside", FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 0, 4, 0x42c80000)}},
    {208, "radius_zero", FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 72, 4, 0)}},
    {208, "weight_negative", FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 68, 4, MINUS_ONE)}},
    {209, "scale_negative", BYTE, SEAL_ALL, {CHUNK("PAGE", 0, 128, 4, MINUS_ONE)}},
    {210, "byte_of_minus_128", BYTE, SEAL_ALL, {CHUNK("PAGE", 0, 195, 1, 0x80)}},
    {211, "grid_too_short", FLOAT, SEAL_ALL, {RESIZE("GRID", 0, 22), CHUNK("GRID", 0, 22, 2, 0)}},
    {212, "blockers_missing", BYTE, SEAL_ALL, {HIDE("BLOK", 0)}},
    {212, "blockers_too_short", BYTE, SEAL_ALL, {RESIZE("BLOK", 0, 11), CHUNK("BLOK", 0, 11, 1, 0)}},

    {301, "geometry_missing", SCENE, SEAL_ALL, {HIDE("GEOM", 1)}},
    {302, "geometry_too_short", SCENE, SEAL_ALL, {RESIZE("GEOM", 1, 172), CHUNK("GEOM", 1, 172, 4, 0)}},
    {303, "pixels_missing", SCENE, SEAL_ALL, {HIDE("PIXL", 0)}},
    {304, "pixels_too_short", SCENE, SEAL_ALL, {RESIZE("PIXL", 0, 12), CHUNK("PIXL", 0, 12, 4, 0)}},
    {305, "index_outside", SCENE, SEAL_ALL, {CHUNK("GEOM", 1, 128, 4, 4)}},
    {305, "material_outside", SCENE, SEAL_ALL, {CHUNK("SUBM", 0, 8, 4, 2)}},
    {305, "texture_outside", SCENE, SEAL_ALL, {CHUNK("MATL", 0, 44, 4, 1)}},
    {305, "mesh_outside", SCENE, SEAL_ALL, {CHUNK("INST", 0, 4, 4, 2)}},
    {306, "index_left_over", SCENE, SEAL_ALL,
     {CHUNK("MESH", 0, 32, 4, 11), CHUNK("SUBM", 0, 28, 4, 9), RESIZE("GEOM", 1, 172),
      CHUNK("GEOM", 1, 172, 4, 0)}},
    {307, "submesh_outside", SCENE, SEAL_ALL, {CHUNK("SUBM", 0, 12, 4, 6)}},
    {308, "normal_not_unit", SCENE, SEAL_ALL, {CHUNK("GEOM", 0, 68, 4, 0x3f000000)}},
    {308, "light_not_unit", SCENE, SEAL_ALL, {CHUNK("LITE", 0, 8, 4, 0x3f800000)}},
    {309, "role_without_object", SCENE, SEAL_ALL, {CHUNK("INST", 0, 8, 4, 2)}},
    {310, "boundary_of_other_role", SCENE, SEAL_ALL, {CHUNK("TRAN", 0, 4, 4, 2)}},
    {311, "matrix_not_affine", SCENE, SEAL_ALL, {CHUNK("INST", 0, 28, 4, 0x3f800000)}},
    {312, "asset_in_other_folder", SCENE, SEAL_ALL, {CHUNK("TEXT", 0, 70, 1, '/')}},
    {313, "camera_on_target", SCENE, SEAL_ALL,
     {CHUNK("CAMR", 0, 16, 4, 0x40000000), CHUNK("CAMR", 0, 20, 4, 0x3fc00000),
      CHUNK("CAMR", 0, 24, 4, 0x40400000)}},
    {314, "no_camera", SCENE, SEAL_ALL, {CHUNK("SCEN", 0, 28, 4, 0), EMPTY("CAMR", 0)}},
    {315, "environment_missing", SCENE, SEAL_ALL, {HIDE("ENVM", 0)}},
    {316, "gap_inside_geometry", SCENE, SEAL_ALL, {CHUNK("GEOM", 1, 63, 1, 1)}},
    {317, "lightmap_on_boundary", LIT, SEAL_ALL, {CHUNK("INLI", 0, 4, 4, 1)}},
    {318, "fog_inside_out", LIT, SEAL_ALL, {CHUNK("FOGS", 0, 40 + 8, 4, 0x40a00000)}},
    {318, "endless_fog_with_bounds", LIT, SEAL_ALL, {CHUNK("FOGS", 0, 8, 4, 0x3f800000)}},
    {130, "nodes_cut_off", MOVING, SEAL_ALL, {RESIZE("NODE", 0, 220), CHUNK("NODE", 0, 220, 4, 0)}},
    {131, "key_not_finite", MOVING, SEAL_ALL, {CHUNK("KEYS", 0, 16, 4, NAN_BITS)}},
    {131, "delta_not_finite", MOVING, SEAL_ALL, {CHUNK("SHAP", 0, 256, 4, NAN_BITS)}},
    {132, "channel_without_keys", MOVING, SEAL_ALL, {CHUNK("CHAN", 0, 12, 4, 0)}},
    {132, "property_unknown", MOVING, SEAL_ALL, {CHUNK("CHAN", 0, 4, 4, 4)}},
    {305, "bound_to_no_node", MOVING, SEAL_ALL, {CHUNK("BIND", 0, 8, 4, 2)}},
    {305, "joint_of_no_node", MOVING, SEAL_ALL, {CHUNK("JONT", 0, 0, 4, 2)}},
    {305, "deform_with_missing_joints", MOVING, SEAL_ALL, {CHUNK("DEFM", 0, 8, 4, 1)}},
    {308, "bind_normal_not_unit", MOVING, SEAL_ALL, {CHUNK("SHAP", 0, 64 + 12, 4, 0x40000000)}},
    {311, "node_not_affine", MOVING, SEAL_ALL, {CHUNK("NODE", 0, 8 + 12, 4, 0x3f800000)}},
    {319, "node_before_parent", MOVING, SEAL_ALL, {CHUNK("NODE", 0, 112 + 4, 4, 1)}},
    {320, "channels_descend", MOVING, SEAL_ALL, {CHUNK("CHAN", 0, 20, 4, 0), CHUNK("CHAN", 0, 24, 4, 0)}},
    {320, "turn_of_three_numbers", MOVING, SEAL_ALL, {CHUNK("CHAN", 0, 20 + 16, 4, 3)}},
    {321, "keys_too_few", MOVING, SEAL_ALL, {RESIZE("KEYS", 0, 164), CHUNK("KEYS", 0, 164, 4, 0)}},
    {322, "times_fall", MOVING, SEAL_ALL, {CHUNK("KEYS", 0, 8, 4, 0x3e800000)}},
    {322, "time_negative", MOVING, SEAL_ALL, {CHUNK("KEYS", 0, 0, 4, MINUS_ONE)}},
    {323, "bindings_descend", MOVING, SEAL_ALL, {CHUNK("BIND", 0, 2 * 76, 4, 1)}},
    {324, "boundary_deformed", MOVING, SEAL_ALL, {CHUNK("DEFM", 0, 0, 4, 1)}},
    {324, "deformed_mesh_shared", MOVING, SEAL_ALL, {CHUNK("INST", 0, 80 * 3 + 4, 4, 1)}},
    {325, "shape_missing", MOVING, SEAL_ALL, {HIDE("SHAP", 0)}},
    {325, "shape_too_short", MOVING, SEAL_ALL, {RESIZE("SHAP", 0, 364), CHUNK("SHAP", 0, 364, 4, 0)}},
    {325, "gap_inside_shape", MOVING, SEAL_ALL, {CHUNK("SHAP", 0, 63, 1, 1)}},
    {326, "joint_outside", MOVING, SEAL_ALL, {CHUNK("SHAP", 0, 128, 2, 2)}},
    {326, "weights_of_half", MOVING, SEAL_ALL, {CHUNK("SHAP", 0, 192, 4, 0x3f000000)}},
    {501, "lightmap_page_missing", MAP, SEAL_ALL, {HIDE("PAGE", 1)}},
    {502, "lightmap_page_too_narrow", MAP, SEAL_ALL, {CHUNK("PAGS", 0, 0, 4, 3)}},
    {503, "gap_inside_lightmap_page", MAP_FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 127, 1, 1)}},
    {504, "irradiance_negative", MAP, SEAL_ALL, {CHUNK("PAGE", 0, 2, 2, 0xbc00)}},
    {504, "float_irradiance_negative", MAP_FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 4, 4, MINUS_ONE)}},
    {505, "state_of_four", MAP_FLOAT, SEAL_ALL, {CHUNK("PAGE", 0, 384 + 5, 1, 4)}},
    {506, "vertices_too_short", MAP, SEAL_ALL, {RESIZE("VERT", 0, 156), CHUNK("VERT", 0, 156, 4, 0)}},
    {507, "lightmap_page_outside", MAP, SEAL_ALL, {CHUNK("INST", 0, 4, 4, 2)}},
    {507, "lightmap_vertex_outside", MAP, SEAL_ALL, {CHUNK("TRIS", 0, 8, 4, 8)}},
    {508, "rectangle_beyond_page", MAP, SEAL_ALL, {CHUNK("INST", 0, 16, 4, 0x3f400000)}},
    {508, "page_uv_outside", MAP, SEAL_ALL, {CHUNK("VERT", 0, 12, 4, MINUS_ONE)}},
    {509, "instances_descend", MAP, SEAL_ALL, {CHUNK("INST", 0, 0, 4, 3)}},
    {509, "triangle_left_over", MAP, SEAL_ALL, {CHUNK("INST", 0, 32 + 28, 4, 1)}},
    {510, "scale_of_floats", MAP_FLOAT, SEAL_ALL, {CHUNK("PAGS", 0, 8, 4, 0x40000000)}},
    {130, "lightmap_instances_too_few", MAP, SEAL_ALL, {CHUNK("INFO", 0, 4, 4, 1)}},
    {131, "irradiance_not_finite", MAP, SEAL_ALL, {CHUNK("PAGE", 0, 2, 2, 0x7c00)}},
    {131, "lightmap_vertex_not_finite", MAP, SEAL_ALL, {CHUNK("VERT", 0, 4, 4, NAN_BITS)}},
    {132, "lightmap_scale_zero", MAP, SEAL_ALL, {CHUNK("PAGS", 0, 8, 4, 0)}},
    {130, "fog_cut_off", LIT, SEAL_ALL, {RESIZE("FOGS", 0, 76), CHUNK("FOGS", 0, 76, 4, 0)}},
    {130, "frames_too_short", MEDIUM, SEAL_ALL, {RESIZE("FRAM", 0, 12), CHUNK("FRAM", 0, 12, 8, 0), CHUNK("FRAM", 0, 20, 4, 0)}},
    {701, "index_missing", MEDIUM, SEAL_ALL, {HIDE("INDX", 1)}},
    {702, "index_too_short", MEDIUM, SEAL_ALL, {RESIZE("INDX", 0, 4), CHUNK("INDX", 0, 4, 4, 0)}},
    {703, "brick_out_of_order", MEDIUM, SEAL_ALL, {CHUNK("INDX", 1, 0, 4, 1)}},
    {703, "brick_left_over", MEDIUM, SEAL_ALL, {CHUNK("INDX", 1, 4, 4, 0xffffffff)}},
    {704, "brick_page_missing", MEDIUM, SEAL_ALL, {HIDE("PAGE", 2)}},
    {705, "brick_page_too_short", MEDIUM, SEAL_ALL, {RESIZE("PAGE", 0, 1456), CHUNK("PAGE", 0, 1456, 2, 0)}},
    {706, "density_above_unit", MEDIUM, SEAL_ALL, {CHUNK("PAGE", 0, 10, 2, 0x7801)}},
    {706, "density_negative", MEDIUM, SEAL_ALL, {CHUNK("PAGE", 2, 0, 2, 0x8000)}},
    {707, "medium_bounds_equal", MEDIUM, SEAL_ALL, {CHUNK("INFO", 0, 88, 4, 0x40300000)}},
    {708, "grid_flat", MEDIUM, SEAL_ALL, {CHUNK("INFO", 0, 24, 4, 0)}},
    {708, "grid_not_affine", MEDIUM, SEAL_ALL, {CHUNK("INFO", 0, 36, 4, 0x3f800000)}},
    {710, "sky_light_missing", SKY, SEAL_ALL, {HIDE("SKYL", 0)}},
    {710, "sky_planes_missing", SKY, SEAL_ALL, {HIDE("SKYC", 0)}},
    {711, "sky_light_too_short", SKY, SEAL_ALL, {RESIZE("SKYL", 0, 358), CHUNK("SKYL", 0, 358, 2, 0)}},
    {712, "sky_depth_negative", SKY, SEAL_ALL, {CHUNK("SKYL", 0, 6, 2, 0xbc00)}},
    {713, "sky_planes_of_none", SKY, SEAL_ALL, {CHUNK("SKYC", 0, 3, 1, 0x36)}},
    {714, "depths_of_a_frame_missing", DEPTH, SEAL_ALL, {HIDE("DEPL", 1)}},
    {714, "depths_unannounced", DEPTH, SEAL_ALL, {HIDE("DEPI", 0)}},
    {715, "depths_too_short", DEPTH, SEAL_ALL, {RESIZE("DEPL", 1, 62), CHUNK("DEPL", 1, 62, 2, 0)}},
    {131, "depth_not_finite", DEPTH, SEAL_ALL, {CHUNK("DEPL", 1, 20, 2, 0x7c00)}},
    {132, "depth_order_six", DEPTH, SEAL_ALL, {CHUNK("DEPI", 0, 12, 4, 6)}},
    {131, "sky_light_not_finite", SKY, SEAL_ALL, {CHUNK("SKYL", 0, 200, 2, 0x7c00)}},
    {132, "sky_order_zero", SKY, SEAL_ALL, {CHUNK("SKYI", 0, 12, 4, 0)}},
    {709, "frames_at_one_time", MEDIUM, SEAL_ALL, {CHUNK("FRAM", 0, 12, 4, 0x3f000000)}},
    {130, "lighting_of_too_few", LIT, SEAL_ALL, {RESIZE("INLI", 0, 8), CHUNK("INLI", 0, 8, 4, 0)}},

    {130, "impulse_info_too_short", IMPULSE, SEAL_ALL, {RESIZE("INFO", 0, 40), CHUNK("INFO", 0, 40, 4, 0)}},
    {131, "table_value_not_finite", IMPULSE, SEAL_ALL, {CHUNK("TABL", 4, 96, 4, NAN_BITS)}},
    {131, "table_angle_not_finite", IMPULSE, SEAL_ALL, {CHUNK("TABL", 7, 64, 4, NAN_BITS)}},
    {132, "emitter_unknown", IMPULSE, SEAL_ALL, {CHUNK("TABL", 0, 0, 4, 3)}},
    {401, "distances_fall", IMPULSE, SEAL_ALL, {CHUNK("INFO", 0, 20, 8, 0x3f40000000000000)}},
    {402, "one_table_too_many", IMPULSE, SEAL_ALL, {CHUNK("INFO", 0, 8, 4, 9)}},
    {403, "table_too_short", IMPULSE, SEAL_ALL, {CHUNK("TABL", 0, 16, 4, 5)}},
    {404, "numbers_of_other_emitter", IMPULSE, SEAL_ALL, {CHUNK("TABL", 0, 28, 4, 6)}},
    {404, "fitted_axis_of_point", IMPULSE, SEAL_ALL, {CHUNK("TABL", 9, 4, 4, 1), CHUNK("TABL", 9, 28, 4, 4)}},
    {405, "even_cosines", IMPULSE, SEAL_ALL, {CHUNK("TABL", 4, 20, 4, 6)}},
    {405, "cosines_of_point", IMPULSE, SEAL_ALL, {CHUNK("TABL", 0, 20, 4, 7)}},
    {406, "events_backwards", IMPULSE, SEAL_ALL, {CHUNK("TABL", 9, 8, 4, 2), CHUNK("TABL", 9, 12, 4, 1)}},
    {406, "event_beyond_the_last", IMPULSE, SEAL_ALL, {CHUNK("TABL", 9, 12, 4, 3)}},
    {407, "second_event_resolved", IMPULSE, SEAL_ALL, {CHUNK("TABL", 7, 8, 4, 2), CHUNK("TABL", 7, 12, 4, 2)}},
    {408, "gap_behind_table_head", IMPULSE, SEAL_ALL, {CHUNK("TABL", 0, 63, 1, 1)}},
    {409, "table_twice", IMPULSE, SEAL_ALL, {CHUNK("TABL", 8, 32, 4, 0)}},
    {410, "event_missing", IMPULSE, SEAL_ALL, 
     {CHUNK("TABL", 1, 8, 4, 1), CHUNK("TABL", 1, 12, 4, 1), CHUNK("TABL", 1, 32, 4, 0x3f000000)}},
    {130, "probes_info_too_short", PROBES, SEAL_ALL, {RESIZE("INFO", 0, 8), CHUNK("INFO", 0, 8, 4, 0)}},
    {131, "probe_not_finite", PROBES, SEAL_ALL, {CHUNK("POSI", 0, 8, 4, NAN_BITS)}},
    {131, "probe_light_not_finite", PROBES, SEAL_ALL, {CHUNK("COEF", 0, 8, 4, NAN_BITS)}},
    {132, "no_probe", PROBES, SEAL_ALL, {CHUNK("INFO", 0, 0, 4, 0)}},
    {601, "probe_light_missing", PROBES, SEAL_ALL, {CHUNK("INFO", 0, 8, 4, 3)}},
    {602, "probe_outside", PROBES, SEAL_ALL, {CHUNK("TETR", 0, 28, 4, 5)}},
    {603, "tetrahedron_inside_out", PROBES, SEAL_ALL,
     {CHUNK("TETR", 0, 0, 4, 1), CHUNK("TETR", 0, 4, 4, 0), CHUNK("NEIG", 0, 0, 4, 0xffffffff),
      CHUNK("NEIG", 0, 4, 4, 1)}},
    {603, "tetrahedron_flat", PROBES, SEAL_ALL, {CHUNK("POSI", 0, 12, 4, 0)}},
    {604, "neighbour_one_way", PROBES, SEAL_ALL, {CHUNK("NEIG", 0, 28, 4, 0xffffffff)}},
    {604, "neighbour_of_other_face", PROBES, SEAL_ALL,
     {CHUNK("NEIG", 0, 0, 4, 0xffffffff), CHUNK("NEIG", 0, 4, 4, 1)}},
};

const size_t refusal_count = sizeof refusals / sizeof *refusals;

/* Takes the chunk's bytes out of the file; what follows moves up. */
static bool empty_chunk(const change *c, forged *f)
{
    size_t count, table = forge_table(*f, &count);
    uint8_t *entry = forge_entry(*f, c->type, c->index);
    if (!entry) return false;
    size_t offset = (size_t)forge_get(entry + 16, 8);
    size_t size = ((size_t)forge_get(entry + 24, 8) + 63) / 64 * 64;
    forge_put(entry + 24, 0, 8);
    forge_put(entry + 32, 0, 8);
    for (size_t i = 0; i < count; i++) {
        uint8_t *other = f->data + table + 48 * i;
        if (other > entry) forge_put(other + 16, forge_get(other + 16, 8) - size, 8);
    }
    forge_put(f->data + 16, f->size - size, 8);
    forge_put(f->data + 24, table - size, 8);
    memmove(f->data + offset, f->data + offset + size, f->size - offset - size);
    f->size -= size;
    return true;
}

static bool apply(const change *c, forged *f)
{
    uint8_t *place = c->target == CHANGE_HEADER  ? f->data
                     : c->target == CHANGE_ENTRY ? forge_entry(*f, c->type, c->index)
                     : c->target == CHANGE_CHUNK ? forge_chunk(*f, c->type, c->index)
                                                 : NULL;
    if (c->target == CHANGE_NONE) return true;
    if (c->target == CHANGE_EMPTY) return empty_chunk(c, f);
    if (c->target == CHANGE_SIZE) {
        bool good = c->value <= f->size;
        f->size = (size_t)c->value;
        return good;
    }
    if (!place || c->at + c->count > (size_t)(f->data + f->size - place)) return false;
    forge_put(place + c->at, c->value, c->count);
    return true;
}

forged refusal_make(const refusal *r, forged base)
{
    forged f = forge_copy(base);
    for (int i = 0; i < REFUSAL_CHANGES; i++)
        if (!apply(&r->changes[i], &f)) {
            free(f.data);
            return (forged){0};
        }
    if (r->seal == SEAL_ALL) forge_seal(f);
    return f;
}
