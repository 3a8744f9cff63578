# The room of the shared reference data under each light and in each fog: room_LIGHT_FOG.json. Its groups are meshes of
# their own, so that the point light and the sun find no lamp in it. In `open` the
# lamp is alone in endless fog.

set(room "${AIRLIGHT_SHARED}/reference/room.obj")
set(bounds "\"bounds_min_m\": [-1.2, -1.2, -1.2], \"bounds_max_m\": [1.2, 1.2, 1.2]")

function(airlight_room light fog mean_free_path_m albedo g density)
  set(meshes "")
  set(groups floor white left right)
  if(light STREQUAL "area")
    list(APPEND groups light)
  elseif(light STREQUAL "open")
    set(groups light)
  endif()
  foreach(group ${groups})
    list(APPEND meshes
      "    {\"name\": \"${group}\", \"file\": \"${room}\", \"node\": \"${group}\", \"lighting\": \"lightmap\"}")
  endforeach()
  list(JOIN meshes ",\n" ROOM_MESHES)
  set(ROOM_LIGHTS "")
  if(light STREQUAL "point")
    set(ROOM_LIGHTS "{\"name\": \"lamp\", \"type\": \"point\", \"position_m\": [0.1, 0.55, 0.25], \"intensity_w_sr\": 2}")
  elseif(light STREQUAL "sun")
    set(ROOM_LIGHTS
      "{\"name\": \"sun\", \"type\": \"directional\", \"direction\": [-0.35, -0.7, -0.9], \"irradiance_w_m2\": 4}")
  endif()
  set(ROOM_FOG "")
  if(NOT fog STREQUAL "none")
    set(ROOM_FOG "\n  \"media\": [\n    {\"name\": \"fog\", \"albedo\": ${albedo}, \"mean_free_path_m\": ${mean_free_path_m}, \"g\": ${g},\n     \"density\": ${density}}\n  ],\n  \"fogs\": [\"fog\"],")
  endif()
  set(ROOM_COMMENT "The room, light: ${light}, fog: ${fog}")
  configure_file(${CMAKE_CURRENT_SOURCE_DIR}/scenes/room_template.json
    ${CMAKE_BINARY_DIR}/tests/scenes/room_${light}_${fog}.json @ONLY)
endfunction()

set(constant "{\"type\": \"constant\", ${bounds}}")
set(endless "{\"type\": \"constant\"}")
set(grid "{\"type\": \"grid\", \"file\": \"${AIRLIGHT_SHARED}/reference/fog.vdb\", ${bounds}}")
foreach(light area point sun)
  airlight_room(${light} none 1 0 0 "${constant}")
  # the mean free path is 1 / sigma_t: 0.1, 0.5, 2 per metre
  airlight_room(${light} thin 10 0.9 0 "${constant}")
  airlight_room(${light} mid 2 0.9 0 "${constant}")
  airlight_room(${light} thick 0.5 0.9 0 "${constant}")
  airlight_room(${light} mid_forward 2 0.9 0.5 "${constant}")
  airlight_room(${light} mid_backward 2 0.9 -0.5 "${constant}")
  airlight_room(${light} mid_absorbing 2 0.5 0 "${constant}")
  airlight_room(${light} grid 1 0.9 0 "${grid}")
endforeach()
airlight_room(open thin 10 0.9 0 "${endless}")
airlight_room(open mid 2 0.9 0 "${endless}")
airlight_room(open thick 0.5 0.9 0 "${endless}")
