# Programs, libraries, headers, the CMake package `airlight` (targets airlight::formats, airlight::runtime)
# and the pkg-config files airlight-formats and airlight-runtime.
include(CMakePackageConfigHelpers)

set(programs airlight-bake airlight-play airlight-inspect airlight-reference airlight-compare airlight-tetrahedra
  airlight-trade)
foreach(program IN LISTS programs)
  if(TARGET ${program})
    install(TARGETS ${program} RUNTIME DESTINATION ${CMAKE_INSTALL_BINDIR})
  endif()
endforeach()

if(TARGET airlight_vdb_bridge)
  install(TARGETS airlight_vdb_bridge LIBRARY DESTINATION ${CMAKE_INSTALL_LIBDIR}/airlight)
endif()

set(package_dir ${CMAKE_INSTALL_LIBDIR}/cmake/airlight)
foreach(library formats runtime)
  if(TARGET airlight_${library})
    set_target_properties(airlight_${library} PROPERTIES EXPORT_NAME ${library})
    install(TARGETS airlight_${library} EXPORT airlight ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR})
    install(DIRECTORY ${library}/include/airlight DESTINATION ${CMAKE_INSTALL_INCLUDEDIR}
      PATTERN program.h EXCLUDE PATTERN image.h EXCLUDE PATTERN trade_table.h EXCLUDE) # of the programs
    configure_file(cmake/airlight-${library}.pc.in airlight-${library}.pc @ONLY)
    install(FILES ${CMAKE_CURRENT_BINARY_DIR}/airlight-${library}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig)
  endif()
endforeach()

install(EXPORT airlight NAMESPACE airlight:: FILE airlightTargets.cmake DESTINATION ${package_dir})
configure_package_config_file(cmake/airlightConfig.cmake.in airlightConfig.cmake INSTALL_DESTINATION ${package_dir})
write_basic_package_version_file(${CMAKE_CURRENT_BINARY_DIR}/airlightConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(FILES ${CMAKE_CURRENT_BINARY_DIR}/airlightConfig.cmake ${CMAKE_CURRENT_BINARY_DIR}/airlightConfigVersion.cmake
  DESTINATION ${package_dir})
install(FILES LICENSE README.md CHANGELOG.md DESTINATION ${CMAKE_INSTALL_DOCDIR})
