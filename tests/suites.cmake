# Registers each suite of a program of tests with ctest, after the program was linked: to load the 250 libraries that most
# of them need takes longer than most tests, so that a process of its own is what a suite has and not each test.
#   cmake -D program=FILE -D folder=NAME -D left_out=FILTER -D registry=FILE -P suites.cmake
# A failure is shown with the name of its test. A skipped test is not one to ctest, to which a failure beside it would be
# skipped as well: ./kestrel counts them in the output.
execute_process(COMMAND ${program} --gtest_list_tests "--gtest_filter=-${left_out}" OUTPUT_VARIABLE listed
                COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE "#[^\n]*" "" listed "${listed}")  # the values of parameters, which hold anything
string(REGEX MATCHALL "\n[A-Za-z0-9_/]+\\. *\n" suites "\n${listed}")
list(TRANSFORM suites REPLACE "[. \n]+" "")
list(REMOVE_DUPLICATES suites)
if(NOT suites)
  message(FATAL_ERROR "${program} lists no tests")
endif()

set(text)
foreach(suite IN LISTS suites)
  string(APPEND text "add_test(\"${folder}.${suite}\" \"${program}\" \"--gtest_filter=${suite}.*-${left_out}\")\n"
                     "set_tests_properties(\"${folder}.${suite}\" PROPERTIES LABELS ${folder} TIMEOUT 900")
  # Those that go by the computer's clock, such as flights over the wires, are not run two at a time.
  if("${folder}.${suite}" MATCHES "^(acceptance|attack|app)\\..*(WireFlights|EveryWire|ServeCommand|FlyCommand|Floods|Ending)")
    string(APPEND text " RESOURCE_LOCK clock")
  endif()
  string(APPEND text ")\n")
endforeach()
file(WRITE ${registry} "${text}")
