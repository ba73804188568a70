include(${CMAKE_CURRENT_LIST_DIR}/content_tests.cmake OPTIONAL)
include(${CMAKE_CURRENT_LIST_DIR}/tree_tests.cmake OPTIONAL)
