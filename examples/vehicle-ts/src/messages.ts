/** What a vehicle says and hears, as docs/wire/schemas has it. Times are the plant's clock, in seconds; lengths metres. */

export type Role = 'primary' | 'secondary';
export type Phase = 'approaching' | 'loading' | 'carrying' | 'unloading' | 'handing_over' | 'returning';
export type Status = 'idle' | 'working' | 'charging' | 'stopped' | 'error';

export interface Transport {
  readonly kind: 'transport';
  readonly item: string;
  readonly quantity: number;
  readonly sources: readonly string[];
  readonly destination: string;
  readonly ability: string;
  readonly goal?: string;
  readonly node?: string;
}

export interface TransportCost {
  readonly kind: 'transport';
  readonly empty_way_s: number;
  readonly loaded_way_s: number;
  readonly energy_s: number;
  readonly suitability_s: number;
}

export interface TaskAnnounced {
  readonly type: 'TaskAnnounced';
  readonly task: string;
  readonly epoch: number;
  readonly role: Role;
  readonly coordinator: string;
  readonly work: Transport | { readonly kind: 'production' };
  readonly deadline_s: number;
  readonly x_m?: number;
  readonly y_m?: number;
  readonly radius_m?: number;
  readonly round?: number;
}

export interface Award {
  readonly type: 'Award';
  readonly task: string;
  readonly epoch: number;
  readonly role: Role;
  readonly work: Transport | { readonly kind: 'production' };
  readonly deadline_s: number;
  readonly source?: string;
  readonly number?: number;
}

export interface Grant {
  readonly person: string;
  readonly valid_until_s: number;
  /** Base64. */
  readonly signature: string;
  readonly areas?: readonly string[];
  readonly everywhere?: boolean;
}

export interface VehicleCommand {
  readonly type: 'VehicleCommand';
  readonly command: string;
  readonly kind: 'stop' | 'acknowledge' | 'resume' | 'set_speed' | 'promise' | 'hand_over' | 'charge' | 'take_out' | 'put_in';
  readonly speed_frac?: number | null;
  readonly wait_s?: number | null;
  readonly issued_by?: string;
  readonly grant?: Grant | null;
}

interface OfTask {
  readonly task: string;
  readonly epoch: number;
}

/** What a coordinator answers in the course of a contract. */
export type Answer = OfTask &
  (
    | { readonly type: 'DockOpened' | 'DockHeld'; readonly station: string; readonly reason?: string }
    | { readonly type: 'HandoverAccepted' | 'Confirmed' | 'Superseded' | 'Withdrawn' }
  );

export interface DwellPointClaimed {
  readonly type: 'DwellPointClaimed';
  readonly dwell_point: string;
  readonly atv: string;
  readonly battery_frac: number;
  readonly standing: boolean;
}

export interface Heartbeat {
  readonly type: 'AtvHeartbeat';
  readonly atv: string;
  readonly incarnation: number;
  readonly seq: number;
  readonly at_s: number;
  readonly status: Status;
  readonly pose: { readonly x_m: number; readonly y_m: number; readonly heading_rad: number };
  readonly node: string;
  readonly speed_mps: number;
  readonly battery_frac: number;
  readonly load: string;
  readonly load_quantity: number;
  readonly task: object | null;
  readonly way: readonly string[];
  readonly dwell_point: string;
  readonly speed_limit_frac: number;
  readonly acknowledged: boolean;
  readonly problem: string;
  readonly software: string;
  readonly draining: boolean;
}

export type Message =
  | TaskAnnounced
  | Award
  | Answer
  | DwellPointClaimed
  | Heartbeat
  | VehicleCommand
  | { readonly type: 'ShutOut'; readonly number: number; readonly agents: readonly string[] }
  | (OfTask & { readonly type: 'Release'; readonly role: Role; readonly reason: string; readonly number: number })
  | (OfTask & { readonly type: 'Resigned'; readonly role: Role; readonly reason: string; readonly detail?: string; readonly short?: string })
  | (OfTask & {
      readonly type: 'Bid';
      readonly role: Role;
      readonly round: number;
      readonly cost: TransportCost;
      readonly finish_s: number;
      readonly source: string;
    })
  | (OfTask & { readonly type: 'Accepted'; readonly role: Role; readonly finish_s: number; readonly number: number })
  | (OfTask & { readonly type: 'Declined'; readonly role: Role; readonly reason: string; readonly number: number })
  | (OfTask & {
      readonly type: 'Docked';
      readonly station: string;
      readonly item?: string;
      readonly quantity?: number;
    })
  | (OfTask & { readonly type: 'Handover'; readonly quantity: number })
  | { readonly type: 'CommandAnswered'; readonly command: string; readonly done: boolean; readonly reason: string | null }
  | { readonly type: 'EventsAsked'; readonly incarnation: number; readonly first: number; readonly last: number }
  | {
      readonly type: 'EventsKept';
      readonly incarnation: number;
      readonly first: number;
      readonly last: number;
      readonly life: number;
    };
