# Tests that go by the computer's clock, such as flights over the wires, are not run two at a time.
foreach(test IN LISTS acceptance_tests_TESTS attack_tests_TESTS app_tests_TESTS)
  if(test MATCHES "WireFlights|EveryWire|ServeCommand|FlyCommand|Floods|Ending")
    set_tests_properties("${test}" PROPERTIES RESOURCE_LOCK clock)
  endif()
endforeach()
