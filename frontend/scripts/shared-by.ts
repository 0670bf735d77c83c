/** What the bundler knows of a module. */
interface Module {
  isEntry: boolean;
  /** Those that load it at once. */
  importers: readonly string[];
  /** Those that load it when somebody looks. */
  dynamicImporters: readonly string[];
}

interface Graph {
  getModuleInfo: (id: string) => Module | null;
}

/**
 * Names the file of a module by the pages that load it at once, where other pages or views need it as well. So a page loads a handful
 * of files, and not one for each set of views that share something: over a thin line each file costs a way there and back.
 *
 * @returns null for what the bundler's own rules place: what one page or view needs alone, and what only views share
 */
export function sharedBy(id: string, graph: Graph): string | null {
  const roots = rootsOf(id, graph);
  const pages = roots.filter((root) => graph.getModuleInfo(root)?.isEntry);
  return roots.length < 2 || pages.length === 0 ? null : pages.map(nameOf).sort().join("-");
}

/** The pages and views with which a module is loaded. */
function rootsOf(id: string, graph: Graph, seen = new Set<string>()): string[] {
  const module = graph.getModuleInfo(id);
  if (module === null || seen.has(id)) return [];
  seen.add(id);
  const above = module.importers.flatMap((importer) => rootsOf(importer, graph, seen));
  return module.isEntry || module.dynamicImporters.length > 0 ? [id, ...above] : above;
}

/** `src/manager/main.tsx` is the page `manager`. */
const nameOf = (entry: string): string => entry.split("/").at(-2) ?? entry;
