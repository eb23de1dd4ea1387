/* Functions since CPython 3.13 that its headers use also where the stable ABI of 3.12 is asked for. */
struct object;
int PyObject_SetAttr(struct object*, struct object*, struct object*);
int PyObject_SetAttrString(struct object*, const char*, struct object*);

int PyObject_DelAttr(struct object* of, struct object* name) {
  return PyObject_SetAttr(of, name, 0);
}
int PyObject_DelAttrString(struct object* of, const char* name) {
  return PyObject_SetAttrString(of, name, 0);
}
