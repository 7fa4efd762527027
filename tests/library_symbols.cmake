# cmake -DNM=... -DLIBRARY=... -DLIST=... -P: what a shared library shows must be what the list says. Who
# changes the list changes the binary interface: the version's second number goes up with it.
execute_process(COMMAND ${NM} --dynamic --defined-only --format=posix ${LIBRARY}
                OUTPUT_VARIABLE text COMMAND_ERROR_IS_FATAL ANY)
string(REGEX REPLACE " [^\n]*" "" text "${text}")
file(READ ${LIST} expected)
if(NOT text STREQUAL expected)
    message(FATAL_ERROR "${LIBRARY} shows\n${text}\nand not, as ${LIST} says,\n${expected}")
endif()
