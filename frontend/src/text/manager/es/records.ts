/** What the management panel says of people and of every list, in Spanish. */
import type { Catalogue } from "../../catalogue";
import type { records as english } from "../en/records";

export const records: Catalogue<typeof english> = {
  "person.menu": "Quién trabaja aquí",
  "person.logOut": "Cerrar sesión",
  "person.role.manager": "Dirección",
  "person.role.operator": "Operario",
  "person.role.admin": "Administrador",
  "person.role.key": "Clave de otro sistema",

  "audit.title": "Registro",

  "filter.find": "Buscar en esta lista",
  "filter.any": "todos",
  "filter.open": "abiertos",
  "filter.inProduction": "planificado o en producción",
  "filter.none": "Nada coincide.",
  "filter.csv": "CSV",
  "filter.csvTitle": "Descargar para una hoja de cálculo",

  "watch.title": "Vigilancia",

  "promises.title": "Promesas",

  "kpis.title": "Cifras en el tiempo",
  "filter.findAll": "Buscar en todo",
  "list.failed": "No se pudo leer la lista: {reason}. Se intenta de nuevo.",
  "list.since": "Desde",
  "list.until": "Hasta",
  "pages.label": "Páginas",
  "pages.before": "Atrás",
  "pages.next": "Más",
};
