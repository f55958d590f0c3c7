/// <reference types="vite/client" />

interface ImportMetaEnv {
  /** Address of a server other than the page's own. */
  readonly VITE_FLANEUR_SERVER?: string;
}
