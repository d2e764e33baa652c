# Writes a C++ file that holds texts: cmake -DOUT=assets.cpp -DFILES="name|path;name|path" -P embed.cmake
# A literal is cut into pieces, since compilers need not take more than 64 kB in one.
set(text "#include \"libsim/report/page.hpp\"\n\nnamespace subsoil::sim {\n")
foreach(entry IN LISTS FILES)
  string(REPLACE "|" ";" parts "${entry}")
  list(GET parts 0 name)
  list(GET parts 1 path)
  file(READ "${path}" hex HEX)
  string(REGEX REPLACE "(................................................................)" "\\1\n" hex "${hex}")
  string(REGEX REPLACE "([0-9a-f][0-9a-f])" "\\\\x\\1" hex "${hex}")
  string(REPLACE "\n" "\"\n    \"" hex "${hex}")
  string(APPEND text "const char* const ${name} =\n    \"${hex}\";\n")
endforeach()
file(WRITE "${OUT}" "${text}}  // namespace subsoil::sim\n")
