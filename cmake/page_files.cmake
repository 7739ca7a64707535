# The scripts and styles of result pages, as C++ strings. A page's own script is these files, in this order, in one scope.
set(page_script)
foreach(file number buttons scale link field chart legend bar events player sweep page)
  list(APPEND page_script src/report/web/${file}.js)
endforeach()
set(page_style src/report/web/page.css src/report/web/live.css)
list(JOIN page_script "," page_script_files)
list(JOIN page_style "," page_style_files)
set(page_files ${PROJECT_BINARY_DIR}/page_files.cpp)
set(page_sources ${page_script} ${page_style} cmake/embed.cmake)
list(TRANSFORM page_sources PREPEND ${PROJECT_SOURCE_DIR}/)
add_custom_command(
  OUTPUT ${page_files}
  COMMAND ${CMAKE_COMMAND} -DOUTPUT=${page_files} -DROOT=${PROJECT_SOURCE_DIR} -P ${PROJECT_SOURCE_DIR}/cmake/embed.cmake --
          script=${page_script_files} style=${page_style_files}
  DEPENDS ${page_sources} VERBATIM)
target_sources(viscobar PRIVATE ${page_files})
