# The headers that most sources read, parsed once for all rooms and once for all tests: a third of the time of a build.
# -DCMAKE_DISABLE_PRECOMPILE_HEADERS=ON (preset sanitize) shows which source leans on that and misses a header of its own.
set(kestrel_common_headers
  <Eigen/Dense> <algorithm> <cmath> <filesystem> <fmt/format.h> <fmt/ranges.h> <functional> <map> <memory> <mutex>
  <numbers> <opencv2/core.hpp> <opencv2/imgproc.hpp> <optional> <set> <span> <sstream> <string> <variant> <vector>)

# kestrel_precompiled(NAME [HEADERS ...] [LIBRARIES ...]): for others to take by REUSE_FROM NAME.
function(kestrel_precompiled name)
  cmake_parse_arguments(PARSE_ARGV 1 its "" "" "HEADERS;LIBRARIES")
  file(CONFIGURE OUTPUT ${CMAKE_BINARY_DIR}/${name}.cc CONTENT "// Only for its precompiled headers.\n")
  add_library(${name} OBJECT ${CMAKE_BINARY_DIR}/${name}.cc)
  target_link_libraries(${name} PRIVATE kestrel_options Eigen3::Eigen fmt::fmt ${OpenCV_LIBS} ${its_LIBRARIES})
  target_precompile_headers(${name} PRIVATE ${kestrel_common_headers} ${its_HEADERS})
endfunction()

# All is compiled with the definitions of what was precompiled, or the compiler could not use it.
target_compile_definitions(kestrel_options INTERFACE $<TARGET_PROPERTY:fmt::fmt,INTERFACE_COMPILE_DEFINITIONS>)
if(CMAKE_CXX_COMPILER_LAUNCHER MATCHES ccache AND CMAKE_CXX_COMPILER_ID STREQUAL "GNU")
  target_compile_options(kestrel_options INTERFACE -fpch-preprocess)  # for ccache to see which headers it stands for
endif()
kestrel_precompiled(kestrel_precompiled)
