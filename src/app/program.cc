#include "impedraw/app/command_line.h"

int main(int argc, char** argv) { return impedraw::command_line(argc, argv); }
