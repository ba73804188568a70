# Installs this build, builds tests/consumer against what was installed, and runs it on a place written
# by the installed program. Wants BUILD (the build folder), SOURCE (tests/consumer) and WORK.
function(run)
  execute_process(COMMAND ${ARGV} RESULT_VARIABLE code OUTPUT_VARIABLE out ERROR_VARIABLE out)
  if(NOT code EQUAL 0)
    message(FATAL_ERROR "${ARGV}: ${code}\n${out}")
  endif()
  set(output "${out}" PARENT_SCOPE)
endfunction()

file(REMOVE_RECURSE ${WORK})
run(${CMAKE_COMMAND} --install ${BUILD} --prefix ${WORK}/prefix)
run(${CMAKE_COMMAND} -S ${SOURCE} -B ${WORK}/build -DCMAKE_PREFIX_PATH=${WORK}/prefix -DCMAKE_BUILD_TYPE=Release)
run(${CMAKE_COMMAND} --build ${WORK}/build)
run(${WORK}/prefix/bin/gnomon demo ${WORK}/place --size 20)
run(${WORK}/build/consumer ${WORK}/place tileset.json)
if(NOT output MATCHES "sun 179\\.[0-9] 62\\.[45].*tiles [1-9][0-9]* complete.*cascades 4")
  message(FATAL_ERROR "the consumer said: ${output}")
endif()
