# airlight_embed(TARGET NAME FOLDER EXTENSION): compiles every FOLDER/*.EXTENSION text into TARGET as
#   const char *const NAME_names[]; const char *const NAME_texts[]; const unsigned NAME_count;
# with the files' own bytes. NAME.h declares them.
function(airlight_embed target name folder)
  file(GLOB files CONFIGURE_DEPENDS ${folder}/*.cl ${folder}/*.glsl ${folder}/*.vert ${folder}/*.frag
       ${folder}/*.comp ${folder}/*.geom ${folder}/*.tesc ${folder}/*.tese)
  list(APPEND files ${ARGN})
  list(SORT files)
  set(source ${CMAKE_CURRENT_BINARY_DIR}/${name}.c)
  add_custom_command(OUTPUT ${source}
    COMMAND ${CMAKE_COMMAND} -DNAME=${name} -DOUT=${source} "-DFILES=${files}" -P ${CMAKE_SOURCE_DIR}/cmake/embed_run.cmake
    DEPENDS ${files} ${CMAKE_SOURCE_DIR}/cmake/embed_run.cmake VERBATIM)
  file(WRITE ${CMAKE_CURRENT_BINARY_DIR}/${name}.h.new
    "extern const char *const ${name}_names[], *const ${name}_texts[];\nextern const unsigned ${name}_count;\n")
  configure_file(${CMAKE_CURRENT_BINARY_DIR}/${name}.h.new ${CMAKE_CURRENT_BINARY_DIR}/${name}.h COPYONLY)
  target_sources(${target} PRIVATE ${source})
  target_include_directories(${target} PRIVATE ${CMAKE_CURRENT_BINARY_DIR})
endfunction()
