# What `cmake --install` puts into a prefix: programs, data, and the rooms that others build on. Nothing of it
# names the source, so the prefix may be moved. Three components: kestrel flies, kestrel-dev is built
# against, kestrel-python is the package for Python.
include(GNUInstallDirs)
include(CMakePackageConfigHelpers)

get_property(programs DIRECTORY app PROPERTY BUILDSYSTEM_TARGETS)
foreach(program IN LISTS programs)
  get_target_property(type ${program} TYPE)
  if(type STREQUAL EXECUTABLE AND NOT program STREQUAL kestrel-run)  # whose verbs are kestrel's, too
    install(TARGETS ${program} RUNTIME DESTINATION bin COMPONENT kestrel)
  endif()
endforeach()

# Below one folder as in the source: the program looks for them there (base/file/data_folders.h).
install(DIRECTORY models DESTINATION share/kestrel COMPONENT kestrel)
install(DIRECTORY scenarios DESTINATION share/kestrel COMPONENT kestrel FILES_MATCHING PATTERN "*.yaml")
install(DIRECTORY base/html/web DESTINATION share/kestrel/base/html COMPONENT kestrel)
install(DIRECTORY campaign/report/page DESTINATION share/kestrel/campaign/report COMPONENT kestrel)
install(DIRECTORY records/page/web DESTINATION share/kestrel/records/page COMPONENT kestrel)
install(FILES app/reproduce/thesis.yaml app/reproduce/reproduce.css DESTINATION share/kestrel/app/reproduce
        COMPONENT kestrel)
install(FILES LICENSE DESTINATION share/doc/kestrel COMPONENT kestrel)

# A component of the package is a layer with all rooms below it.
set(below_vision base geometry)
set(below_control base geometry)
set(below_mission base geometry vision control)
set(below_sim base geometry vision control)
set(below_flight base geometry vision control mission records scenarios)
set(components vision control mission flight)
if(KESTREL_TARGET STREQUAL "simulator")
  list(APPEND components sim)
  list(APPEND below_flight sim)
endif()

get_property(rooms GLOBAL PROPERTY kestrel_room_names)
foreach(room IN LISTS rooms)
  string(REGEX REPLACE "/.*" "" layer ${room})
  if(layer MATCHES "^(app|bench|campaign)$")
    continue()
  endif()
  string(REPLACE / _ name ${room})
  list(APPEND rooms_of_${layer} kestrel_${name})
  set_target_properties(kestrel_${name} PROPERTIES EXPORT_NAME room_${name})
  install(TARGETS kestrel_${name} EXPORT kestrel ARCHIVE DESTINATION ${CMAKE_INSTALL_LIBDIR}/kestrel COMPONENT kestrel-dev)
  file(GLOB headers CONFIGURE_DEPENDS ${room}/*.h)
  install(FILES ${headers} DESTINATION include/kestrel/${room} COMPONENT kestrel-dev)
endforeach()

foreach(component IN LISTS components)
  add_library(kestrel_component_${component} INTERFACE)
  set_target_properties(kestrel_component_${component} PROPERTIES EXPORT_NAME ${component})
  target_compile_features(kestrel_component_${component} INTERFACE cxx_std_20)
  target_compile_definitions(kestrel_component_${component} INTERFACE EIGEN_MAX_ALIGN_BYTES=32
                                                                    EIGEN_MAX_STATIC_ALIGN_BYTES=16)  # as here
  foreach(layer ${component} ${below_${component}})
    target_link_libraries(kestrel_component_${component} INTERFACE ${rooms_of_${layer}})
  endforeach()
  install(TARGETS kestrel_component_${component} EXPORT kestrel COMPONENT kestrel-dev)
endforeach()

install(TARGETS kestrel_plugin EXPORT kestrel COMPONENT kestrel-dev)
list(APPEND components plugin)

set(package ${CMAKE_INSTALL_LIBDIR}/cmake/kestrel)
foreach(library apriltag embree TIFF)
  if(NOT ${library}_FOUND)
    set(${library}_FOUND FALSE)
  endif()
endforeach()
configure_package_config_file(kestrelConfig.cmake.in ${CMAKE_BINARY_DIR}/package/kestrelConfig.cmake INSTALL_DESTINATION ${package})
# Before 1.0 a minor version may change what others build on.
write_basic_package_version_file(${CMAKE_BINARY_DIR}/package/kestrelConfigVersion.cmake COMPATIBILITY SameMinorVersion)
install(EXPORT kestrel NAMESPACE kestrel:: FILE kestrelTargets.cmake DESTINATION ${package} COMPONENT kestrel-dev)
install(FILES ${CMAKE_BINARY_DIR}/package/kestrelConfig.cmake ${CMAKE_BINARY_DIR}/package/kestrelConfigVersion.cmake
              kestrelPlugin.cmake
        DESTINATION ${package} COMPONENT kestrel-dev)

# pkg-config, for builds without CMake: a file for each component, which finds the prefix from where it lies.
set(layers_base base geometry)
set(layers_vision vision)
set(layers_control control)
set(layers_sim sim)
set(layers_flight mission records scenarios flight)
set(needs_base "eigen3 fmt yaml-cpp liblz4 libzstd")
set(needs_vision "kestrel-base opencv4 gstreamer-1.0 gio-2.0")
if(aravis_FOUND)
  string(APPEND needs_vision " aravis-0.8")
endif()
if(apriltag_FOUND)
  string(APPEND needs_vision " apriltag")
endif()
if(TIFF_FOUND)
  string(APPEND needs_vision " libtiff-4")
endif()
if(dlib_FOUND)
  set(libraries_vision "-lblas")  # which has no file of its own
endif()
set(needs_control "kestrel-base")
set(needs_sim "kestrel-vision kestrel-control pugixml libhwy libxxhash")
if(embree_FOUND)
  set(embree -lembree${embree_VERSION_MAJOR})
endif()
set(libraries_sim "-lmujoco -lassimp ${embree} -ldl")  # which have no file of their own
set(needs_flight "kestrel-vision kestrel-control nlohmann_json pugixml")
if(TARGET kestrel_sim)
  string(PREPEND needs_flight "kestrel-sim ")
endif()
file(RELATIVE_PATH up /${CMAKE_INSTALL_LIBDIR}/pkgconfig /)
foreach(component base vision control sim flight)
  set(libraries)
  foreach(layer IN LISTS layers_${component})
    foreach(room IN LISTS rooms_of_${layer})
      get_target_property(type ${room} TYPE)
      if(type STREQUAL STATIC_LIBRARY)
        string(APPEND libraries ",-l${room}")
      endif()
    endforeach()
  endforeach()
  if(NOT libraries)
    continue()
  endif()
  # The group is one word: pkg-config gives a word that several files have but once.
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/package/kestrel-${component}.pc @ONLY CONTENT
"prefix=\${pcfiledir}/@up@
Name: kestrel-${component}
Description: Kestrel, flight by vision: ${component}
Version: ${PROJECT_VERSION}
Requires: ${needs_${component}}
Cflags: -std=c++20 -DEIGEN_MAX_ALIGN_BYTES=32 -DEIGEN_MAX_STATIC_ALIGN_BYTES=16 -I\${prefix}/include/kestrel
Libs: -L\${prefix}/${CMAKE_INSTALL_LIBDIR}/kestrel -Wl,--start-group${libraries},--end-group ${libraries_${component}} -pthread
")
  install(FILES ${CMAKE_BINARY_DIR}/package/kestrel-${component}.pc DESTINATION ${CMAKE_INSTALL_LIBDIR}/pkgconfig
          COMPONENT kestrel-dev)
endforeach()

# Debian packages: `cpack -G DEB` in the build folder. kestrel flies; libkestrel-dev is built against; python3-kestrel
# is for Python.
set(CPACK_PACKAGE_NAME kestrel)
set(CPACK_PACKAGE_CONTACT "Kestrel's developers <kestrel@localhost>")
set(CPACK_PACKAGE_DESCRIPTION_SUMMARY "Software-in-the-loop simulator for vision-guided flight")
set(CPACK_PACKAGING_INSTALL_PREFIX /usr)
set(CPACK_STRIP_FILES ON)
set(CPACK_COMPONENTS_ALL kestrel kestrel-dev)
if(TARGET kestrel_python)
  list(APPEND CPACK_COMPONENTS_ALL kestrel-python)
  set(CPACK_DEBIAN_KESTREL-PYTHON_PACKAGE_NAME python3-kestrel)
  set(CPACK_DEBIAN_KESTREL-PYTHON_PACKAGE_SECTION python)
  set(CPACK_DEBIAN_KESTREL-PYTHON_PACKAGE_SHLIBDEPS ON)
  math(EXPR next ${Python3_VERSION_MINOR}+1)
  string(CONCAT CPACK_DEBIAN_KESTREL-PYTHON_PACKAGE_DEPENDS "kestrel (= ${PROJECT_VERSION}), "
         "python3 (>= 3.${Python3_VERSION_MINOR}~), python3 (<< 3.${next}), python3-numpy")
  set(CPACK_DEBIAN_KESTREL-PYTHON_PACKAGE_SUGGESTS "python3-pandas")
endif()
set(CPACK_DEB_COMPONENT_INSTALL ON)
set(CPACK_DEBIAN_FILE_NAME DEB-DEFAULT)
set(CPACK_DEBIAN_PACKAGE_SECTION science)
set(CPACK_DEBIAN_KESTREL_PACKAGE_NAME kestrel)
set(CPACK_DEBIAN_KESTREL_PACKAGE_SHLIBDEPS ON)
# Opened at run time, so no library says so: drawing without a screen.
set(CPACK_DEBIAN_KESTREL_PACKAGE_DEPENDS "libosmesa6 | libegl1")
set(CPACK_DEBIAN_KESTREL_PACKAGE_RECOMMENDS "ffmpeg, gnuplot-nox, libjs-chart.js, libjs-three")
# Of cameras that send RTP or are pipelines of GStreamer; they bring in 75 packages.
set(CPACK_DEBIAN_KESTREL_PACKAGE_SUGGESTS "gstreamer1.0-plugins-base, gstreamer1.0-plugins-good")
set(CPACK_DEBIAN_KESTREL-DEV_PACKAGE_NAME libkestrel-dev)
set(CPACK_DEBIAN_KESTREL-DEV_PACKAGE_SECTION libdevel)
string(CONCAT CPACK_DEBIAN_KESTREL-DEV_PACKAGE_DEPENDS
       "kestrel (= ${PROJECT_VERSION}), libeigen3-dev, libboost-dev, libfmt-dev, libyaml-cpp-dev, libopencv-dev, "
       "libgstreamer1.0-dev, nlohmann-json3-dev, libpugixml-dev, libmujoco-dev, libqhull-dev, libgl-dev, libopengl-dev, "
       "libassimp-dev, libembree-dev, libhwy-dev, libxxhash-dev, pkg-config")
if(aravis_FOUND)
  string(APPEND CPACK_DEBIAN_KESTREL-DEV_PACKAGE_DEPENDS ", libaravis-dev, libusb-1.0-0-dev")
endif()
if(apriltag_FOUND)
  string(APPEND CPACK_DEBIAN_KESTREL-DEV_PACKAGE_DEPENDS ", libapriltag-dev")
endif()
if(TIFF_FOUND)
  string(APPEND CPACK_DEBIAN_KESTREL-DEV_PACKAGE_DEPENDS ", libtiff-dev")
endif()
if(dlib_FOUND)
  string(APPEND CPACK_DEBIAN_KESTREL-DEV_PACKAGE_DEPENDS ", libblas-dev")
endif()
include(CPack)
