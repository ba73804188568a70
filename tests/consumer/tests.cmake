add_test(NAME Install.AConsumerBuildsAgainstTheInstalledLibraries
  COMMAND ${CMAKE_COMMAND} -DBUILD=${PROJECT_BINARY_DIR} -DSOURCE=${CMAKE_CURRENT_LIST_DIR}
    -DWORK=${PROJECT_BINARY_DIR}/consumer -P ${CMAKE_CURRENT_LIST_DIR}/consumer_test.cmake)
set_tests_properties(Install.AConsumerBuildsAgainstTheInstalledLibraries PROPERTIES TIMEOUT 300)
