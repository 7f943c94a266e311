# A plug-in of Kestrel from sources: a shared object that `kestrel --plugin` loads.
function(kestrel_add_plugin name)
  add_library(${name} MODULE ${ARGN})
  set_target_properties(${name} PROPERTIES PREFIX "")
  target_link_libraries(${name} PRIVATE kestrel::plugin)
endfunction()
