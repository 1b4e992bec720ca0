/* heartbus: a program of any kind takes part in a coupled run of the heart.
 *
 *     heartbus_bus *bus;
 *     int code = heartbus_join(&bus, "ep", "my_ep");
 *     if (code)
 *       return code;
 *     ... heartbus_points, heartbus_output, heartbus_input, heartbus_task, heartbus_scalar ...
 *     heartbus_order order;
 *     while (heartbus_next(bus, &order))
 *       if (order.what == HEARTBUS_SOLVE)
 *         ...
 *     return heartbus_leave(bus);
 *
 * All values are in SI units (calcium in uM), the configuration of all points is the reference one. Every call is
 * made by all ranks of a participant, in the same order. When something fails, here or elsewhere, the launch ends:
 * the message has been printed by the coupler, heartbus_next returns HEARTBUS_END, calls that return pointers return
 * null, and heartbus_leave returns the exit code that the program is to end with.
 *
 * The library links MPI and nothing else. It neither exits nor touches signals, environment or cores. Only if the
 * coupler does not answer any more does it end the launch by MPI_Abort.
 *
 * Fortran and Python modules are generated from this file (api/generate.py). */
#ifndef HEARTBUS_H
#define HEARTBUS_H

#ifdef __cplusplus
extern "C" {
#endif

#if defined(__GNUC__)
#define HEARTBUS_API __attribute__((visibility("default")))
#else
#define HEARTBUS_API
#endif

/* This interface; a library with the same first number serves programs that were built with an earlier second one. */
#define HEARTBUS_VERSION_MAJOR 1
#define HEARTBUS_VERSION_MINOR 0

/* Exit codes of all programs of a launch; mpirun ends with the culprit's. */
#define HEARTBUS_OK 0
#define HEARTBUS_UNFORESEEN 1    /* anything that has no code of its own */
#define HEARTBUS_SCENE 2         /* the scene or a setting is wrong */
#define HEARTBUS_HANDSHAKE 3     /* participants, versions, fields or units do not fit together */
#define HEARTBUS_MAP 4           /* point sets do not match */
#define HEARTBUS_NOT_CONVERGED 5 /* an iteration failed */
#define HEARTBUS_NOT_FINITE 6    /* NaN or infinity */
#define HEARTBUS_DEADLINE 7      /* somebody waited too long */
#define HEARTBUS_FILE 8          /* a file cannot be read or written */

/* What a participant is ordered to do. Outputs are sent and inputs filled between one order and the next. */
#define HEARTBUS_END 0     /* nothing more: leave */
#define HEARTBUS_PREPARE 1 /* once a step, before its first solve */
#define HEARTBUS_SOLVE 2   /* any number of times in a step, always from the state of the last commit */
#define HEARTBUS_COMMIT 3  /* the last solve counts: new becomes old */
#define HEARTBUS_TASK 4    /* what has been declared by heartbus_task under the name `text` */
#define HEARTBUS_SAVE 5    /* the state into a file of the folder `text`: all that the next step depends on */
#define HEARTBUS_LOAD 6    /* the state from there, in place of the start: outputs too are as after that step */
#define HEARTBUS_REFRESH 7 /* drop what is not in the state: preconditioners, guesses */
#define HEARTBUS_FINISH 8  /* after the last step: last output */

/* How the values that the ranks have of a scalar become one. */
#define HEARTBUS_FIRST 0 /* that of rank 0 */
#define HEARTBUS_MIN 1
#define HEARTBUS_MAX 2
#define HEARTBUS_SUM 3

/* One process's membership of the launch. */
typedef struct heartbus_bus heartbus_bus;

typedef struct {
  int what;         /* HEARTBUS_SOLVE, ... */
  int number;       /* of the step that is computed, from 1; 0 before the first */
  int iteration;    /* of the coupling within the step, from 0 */
  double time;      /* at the end of the step [s] */
  double size;      /* of the step [s] */
  const char *text; /* name of the task, or folder of the state */
} heartbus_order;

typedef struct {
  int n_points;
  const double *points; /* three coordinates each [m] */
  double spacing;       /* smallest distance between neighbours [m] */
  int n_faces;          /* between the points, where the partner has told them */
  int n_corners;        /* of a face */
  const int *faces;     /* numbers of points, from 0, counter-clockwise seen from outside the partner's body */
} heartbus_partner_points;

/* Joins the launch and waits for the coupler; initialises MPI unless the program has done so (MPI_THREAD_SERIALIZED is
 * enough), and finalises it then, too. The name is that of the scene: HEARTBUS_NAME, which the launcher sets, goes
 * before `name`. Returns 0, or the exit code that the program is to end with: what is wrong has been printed. */
HEARTBUS_API int heartbus_join(heartbus_bus **bus, const char *name, const char *program);

/* The ranks of this participant alone, as a Fortran handle: MPI_Comm_f2c makes it one of C. Belongs to the bus. */
HEARTBUS_API int heartbus_communicator(heartbus_bus *bus);

/* What the scene says under participants.NAME.settings, in `unit` ("Pa", "ms"; "1" for plain numbers), whatever unit it
 * is written in there. `value` keeps what it has when the scene says nothing. Returns 0, or a code when it is wrong. */
HEARTBUS_API int heartbus_setting(heartbus_bus *bus, const char *key, const char *unit, double *value);

/* The same for words; `fallback` (may be null) when the scene says nothing. Belongs to the bus. */
HEARTBUS_API const char *heartbus_setting_text(heartbus_bus *bus, const char *key, const char *fallback);

/* The whole scene as YAML with every key, and the folder of the results, which exists. Belong to the bus. */
HEARTBUS_API const char *heartbus_scene(heartbus_bus *bus);
HEARTBUS_API const char *heartbus_folder(heartbus_bus *bus);

/* The points of another participant's point set, with faces: for those who have no mesh of their own. Waits until that
 * one has declared them. All ranks get all points. The arrays belong to the bus and stay. Returns 0 or a code. */
HEARTBUS_API int heartbus_partner(heartbus_bus *bus, const char *participant, const char *point_set,
                                  heartbus_partner_points *points);

/* Points that this rank owns, three coordinates each [m]; `spacing` is the smallest distance between neighbours [m], to
 * which the tolerance of the matching is relative. The order is that of the values of its fields. */
HEARTBUS_API int heartbus_points(heartbus_bus *bus, const char *name, int n_points, const double *points,
                                 double spacing);

/* A field that others may receive: `components` values a point, one point after the other. With an empty
 * `point_set` the values belong to no point (a pressure, a volume); those of rank 0 count. Returns the array, all
 * zero, to be filled at each solve; it belongs to the bus and stays where it is. On a rank without points it is not
 * null either. */
HEARTBUS_API double *heartbus_output(heartbus_bus *bus, const char *field, const char *point_set, int components,
                                     const char *unit);

/* A field that others may send. The array is filled before the order that needs it. */
HEARTBUS_API double *heartbus_input(heartbus_bus *bus, const char *field, const char *point_set, int components,
                                    const char *unit);

/* A number for the history of the run, read after each commit from the returned place. */
HEARTBUS_API double *heartbus_scalar(heartbus_bus *bus, const char *name, const char *unit, int combine);

/* Something that a scheme may order by name. */
HEARTBUS_API int heartbus_task(heartbus_bus *bus, const char *name);

/* Waits, asleep, for the next order, which is done when this is called again. The first call ends the declarations.
 * Returns order->what; HEARTBUS_END (0) at the end and after a failure. */
HEARTBUS_API int heartbus_next(heartbus_bus *bus, heartbus_order *order);

/* Ends the launch: the coupler prints the message with this participant's name and rank. Returns the exit code. */
HEARTBUS_API int heartbus_fail(heartbus_bus *bus, int code, const char *message);

/* Waits until all have come to the end, and frees the bus. Returns the exit code that the program is to end with: if it
 * is not 0, at once and without MPI_Finalize, which would wait for the others. */
HEARTBUS_API int heartbus_leave(heartbus_bus *bus);

/* Of the protocol that the library speaks: all programs of a launch speak the same. */
HEARTBUS_API int heartbus_protocol(void);

#ifdef __cplusplus
}
#endif

#endif
