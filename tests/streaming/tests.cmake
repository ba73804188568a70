include(${CMAKE_CURRENT_LIST_DIR}/content_tests.cmake)
include(${CMAKE_CURRENT_LIST_DIR}/tree_tests.cmake)
