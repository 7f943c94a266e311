# A room is a folder with one subject: a library of the sources that lie directly in it, and what it may include.
#   kestrel_room(vision/camera PUBLIC geometry Eigen3::Eigen PRIVATE base fmt::fmt)
# PUBLIC: named by its headers; PRIVATE: by its sources alone. What names a folder of ours is a room, anything else
# a library. A test reads what is declared here, and fails on an include that is not.

set(kestrel_headers $<BUILD_INTERFACE:${CMAKE_SOURCE_DIR}> $<INSTALL_INTERFACE:include/kestrel>)

# The same for any target.
function(kestrel_link target)
  set(linked)
  foreach(each IN LISTS ARGN)
    if(IS_DIRECTORY ${CMAKE_SOURCE_DIR}/${each} AND NOT IS_ABSOLUTE ${each})
      string(REPLACE / _ each kestrel_${each})
    endif()
    list(APPEND linked ${each})
  endforeach()
  target_link_libraries(${target} ${linked})
endfunction()

function(kestrel_room room)
  string(REPLACE / _ target kestrel_${room})
  file(GLOB sources CONFIGURE_DEPENDS ${CMAKE_SOURCE_DIR}/${room}/*.cc)
  set_property(GLOBAL APPEND_STRING PROPERTY kestrel_rooms "${room} ${ARGN}\n")
  set_property(GLOBAL APPEND PROPERTY kestrel_room_names ${room})
  if(sources)
    add_library(${target} STATIC ${sources})
    target_include_directories(${target} PUBLIC ${kestrel_headers})
    kestrel_link(${target} ${ARGN} PRIVATE $<BUILD_INTERFACE:kestrel_options>)
    if(TARGET kestrel_precompiled)
      target_precompile_headers(${target} REUSE_FROM kestrel_precompiled)
    endif()
  else()
    add_library(${target} INTERFACE)
    target_include_directories(${target} INTERFACE ${kestrel_headers})
    list(TRANSFORM ARGN REPLACE "^(PUBLIC|PRIVATE)$" INTERFACE)
    kestrel_link(${target} ${ARGN})
  endif()
endfunction()
