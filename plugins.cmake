# A plug-in is a shared object that leaves what it uses of Kestrel to the program that loads it. So the programs
# export all that a mission may use: every room from base to records, whether the program itself uses it or not.
get_property(rooms GLOBAL PROPERTY kestrel_room_names)
list(FILTER rooms INCLUDE REGEX "^(base|geometry|vision|control|mission|records)(/|$)")
list(FILTER rooms EXCLUDE REGEX "^vision/(capture|calibration)$")  # which bring in the cameras' libraries
list(TRANSFORM rooms REPLACE / _)
list(TRANSFORM rooms PREPEND kestrel_)
set(libraries)
foreach(room IN LISTS rooms)
  get_target_property(type ${room} TYPE)
  if(type STREQUAL STATIC_LIBRARY)
    list(APPEND libraries ${room})
  endif()
endforeach()
list(TRANSFORM libraries REPLACE "(.+)" "$<TARGET_FILE:\\1>" OUTPUT_VARIABLE files)

get_property(programs DIRECTORY app PROPERTY BUILDSYSTEM_TARGETS)
foreach(program IN LISTS programs)
  get_target_property(type ${program} TYPE)
  if(type STREQUAL EXECUTABLE)
    set_target_properties(${program} PROPERTIES ENABLE_EXPORTS ON)
    # Whole once, before all else; where the linker meets them again, nothing of them is missing.
    target_link_options(${program} PRIVATE -Wl,--push-state,--whole-archive ${files} -Wl,--pop-state)
    target_link_libraries(${program} PRIVATE ${libraries})
    target_link_options(${program} PRIVATE -Wl,--as-needed)  # of the libraries, those that are used
  endif()
endforeach()

# What a plug-in is compiled with; it is linked with none of the rooms.
get_property(version GLOBAL PROPERTY kestrel_version)
add_library(kestrel_plugin INTERFACE)
set_target_properties(kestrel_plugin PROPERTIES EXPORT_NAME plugin)
target_compile_features(kestrel_plugin INTERFACE cxx_std_20)
target_compile_definitions(kestrel_plugin INTERFACE EIGEN_MAX_ALIGN_BYTES=32 EIGEN_MAX_STATIC_ALIGN_BYTES=16
                                                    KESTREL_VERSION="${version}")
target_include_directories(kestrel_plugin INTERFACE ${kestrel_headers})
target_link_libraries(kestrel_plugin INTERFACE Eigen3::Eigen Boost::headers fmt::fmt ${OpenCV_LIBS})
add_library(kestrel::plugin ALIAS kestrel_plugin)
include(kestrelPlugin.cmake)
